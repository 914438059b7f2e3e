"""The faults that can be injected into a MAx-4 controller; `power.py` implements their effects."""

from typing import Annotated, Final, Literal

from pydantic import Field

from fieldrig.faults.faults import Timed, models_of


class PowerOff(Timed):
    """The controller has no power; it boots when the fault ends."""

    what: Literal["power_off"]
    days: float = Field(default=0.0, ge=0, description="simulated days without power; buffered memory lasts 7")


class MemoryLost(Timed):
    """Buffered memory loses its content, immediately and at every power-on."""

    what: Literal["memory_lost"]


class Overrun(Timed):
    """Every cycle of the real-time process takes longer."""

    what: Literal["overrun"]
    us: int = Field(ge=1, le=1_000_000, description="additional duration of every cycle")


Max4Fault = Annotated[PowerOff | MemoryLost | Overrun, Field(discriminator="what")]
MODELS: Final = models_of(Max4Fault)
