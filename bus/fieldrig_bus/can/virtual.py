"""`can.virtual`: a CAN bus in virtual time.  What the medium does is in `model`; the hub runs the same in real time."""

from typing import ClassVar, Self

from pydantic import Field, model_validator

from fieldrig.bus import ModelBus, Time
from fieldrig.settings import Settings
from fieldrig_bus.can import codec
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.model import CanBusModel


class CanSettings(Settings):
    bitrate: int | None = Field(
        default=500_000, ge=10_000, le=1_000_000, description="bit/s; null: unpaced, frames take no time"
    )
    data_bitrate: int | None = Field(
        default=None, ge=10_000, le=8_000_000, description="bit/s of CAN FD frames that switch their bit rate"
    )

    @model_validator(mode="after")
    def _check_bit_rates(self) -> Self:
        if self.data_bitrate is not None and (self.bitrate is None or self.data_bitrate < self.bitrate):
            raise ValueError("data_bitrate: at least as high as bitrate, and only where there is a bitrate")
        return self


class CanModelBus(ModelBus[CanFrame]):
    """What the CAN buses on our own model have in common."""

    family: ClassVar[str] = "can"
    messages: ClassVar[tuple[type, ...]] = (CanFrame,)
    settings: CanSettings

    encode = staticmethod(codec.encode)
    decode = staticmethod(codec.decode)
    show = staticmethod(codec.show)

    def model(self) -> CanBusModel:
        return CanBusModel(self.settings.bitrate, self.settings.data_bitrate)

    def python_can(self) -> dict[str, object] | None:
        """What `can.Bus(...)` takes to join from outside; None where nobody can."""
        return None


class CanVirtual(CanModelBus):
    about: ClassVar[str] = "CAN bus with arbitration and exact bit times, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})

    def __init__(self, name: str, settings: CanSettings) -> None:
        super().__init__(name, settings)
