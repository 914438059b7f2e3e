"""`can.virtual`: a CAN bus in virtual time.  What the medium does is in `model`; the hub runs the same in real time."""

from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from fieldrig.bus import ModelBus, Time
from fieldrig.settings import Settings
from fieldrig_bus.can import acceptance, codec
from fieldrig_bus.can.faults import PACED, CanFault
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.member import Controller
from fieldrig_bus.can.model import CanBusModel, CanMessage
from fieldrig_bus.can.notices import BitRate, BusState, CanControl, CanError, FaultNote


class CanSettings(Settings):
    bitrate: int | None = Field(
        default=500_000, ge=10_000, le=1_000_000, description="bit/s; null: unpaced, frames take no time"
    )
    data_bitrate: int | None = Field(
        default=None, ge=10_000, le=8_000_000, description="bit/s of CAN FD frames that switch their bit rate"
    )
    recovery: Literal["auto", "manual"] = Field(
        default="auto", description="out of bus-off: as soon as the standard lets it, or when the member asks for it"
    )
    acknowledge: Literal["members", "always"] = Field(
        default="members", description="who acknowledges: other members only, or the rig too, so nobody is ever alone"
    )
    controllers: dict[str, Controller] = Field(default={}, description="members whose controller is not a plain one")
    faults: list[CanFault] = Field(default=[], description="that the bus has from the start")

    @model_validator(mode="after")
    def _check_faults(self) -> Self:
        for number, fault in enumerate(self.faults):
            if self.bitrate is None and isinstance(fault, PACED):
                raise ValueError(f"faults.{number}: {fault.what} needs a bus with a bitrate")
        return self

    @model_validator(mode="after")
    def _check_bit_rates(self) -> Self:
        if self.data_bitrate is not None and (self.bitrate is None or self.data_bitrate < self.bitrate):
            raise ValueError("data_bitrate: at least as high as bitrate, and only where there is a bitrate")
        return self


class CanModelBus(ModelBus[CanMessage]):
    """What the CAN buses on our own model have in common."""

    family: ClassVar[str] = "can"
    messages: ClassVar[tuple[type, ...]] = (CanFrame, CanError, BusState, FaultNote, CanControl, BitRate)
    settings: CanSettings

    encode = staticmethod(codec.encode)
    decode = staticmethod(codec.decode)
    show = staticmethod(codec.show)
    check = staticmethod(codec.check_sent)
    check_interest = staticmethod(acceptance.check_interest)

    @staticmethod
    def standing_of(message: CanMessage) -> str | None:
        return "bit rate" if type(message) is BitRate else None

    def model(self) -> CanBusModel:
        settings = self.settings
        return CanBusModel(
            settings.bitrate,
            settings.data_bitrate,
            settings.controllers,
            settings.faults,
            is_recovering_by_itself=settings.recovery == "auto",
            is_acknowledged=settings.acknowledge == "always",
        )

    def python_can(self) -> dict[str, object] | None:
        """What `can.Bus(...)` takes to join from outside; None where nobody can."""
        return None


class CanVirtual(CanModelBus):
    about: ClassVar[str] = "CAN bus with arbitration and exact bit times, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})

    def __init__(self, name: str, settings: CanSettings) -> None:
        super().__init__(name, settings)
