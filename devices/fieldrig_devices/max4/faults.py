"""The faults that a MAx-4 controller takes.  `controller.py` says what each of them does."""

from typing import Annotated, Final, Literal

from pydantic import Field

from fieldrig.faults import Timed, models_of


class PowerOff(Timed):
    """The controller has no power.  When the fault is over, it boots."""

    what: Literal["power_off"]
    days: float = Field(default=0.0, ge=0, description="days that the controller takes it for; buffered memory lasts 7")


class MemoryLost(Timed):
    """Buffered memory loses its content, at once and at every power-on."""

    what: Literal["memory_lost"]


class Overrun(Timed):
    """Every cycle of the real-time process takes longer."""

    what: Literal["overrun"]
    us: int = Field(ge=1, le=1_000_000, description="extra time of every cycle")


Max4Fault = Annotated[PowerOff | MemoryLost | Overrun, Field(discriminator="what")]
MODELS: Final = models_of(Max4Fault)
