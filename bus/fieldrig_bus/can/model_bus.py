"""`CanModelBus`: what the CAN buses whose medium is our model have in common, and their settings.

`model` is the medium; it paces the frames at the bit rate.
"""

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from fieldrig.bus import ModelBus
from fieldrig.settings import Settings
from fieldrig_bus.can.codec import CanMessage
from fieldrig_bus.can.family import CanFamily
from fieldrig_bus.can.faults import PACED, CanFault
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.given_fault import MODELS
from fieldrig_bus.can.member import Controller
from fieldrig_bus.can.model import CanBusModel
from fieldrig_bus.can.notices import BitRate, BusState, CanControl, CanError, FaultNote


class CanSettings(Settings):
    """Settings of the CAN buses on our own model."""

    bitrate: int | None = Field(
        default=500_000, ge=10_000, le=1_000_000, description="bit/s; null: unpaced, frames take no time"
    )
    data_bitrate: int | None = Field(
        default=None, ge=10_000, le=8_000_000, description="bit/s of CAN FD frames that switch their bit rate"
    )
    recovery: Literal["auto", "manual"] = Field(
        default="auto",
        description="recovery from bus-off: as soon as the standard allows, or when the member asks for it",
    )
    acknowledge: Literal["members", "always"] = Field(
        default="members",
        description="which members acknowledge frames; `always` includes the rig, so that a single member can transmit",
    )
    controllers: dict[str, Controller] = Field(default={}, description="members with a special controller, by name")
    faults: list[CanFault] = Field(default=[], description="faults that the bus has from the start")

    @model_validator(mode="after")
    def _check_faults(self) -> Self:
        for number, fault in enumerate(self.faults):
            if self.bitrate is None and isinstance(fault, PACED):
                raise ValueError(f"faults.{number}: {fault.what} needs a bus with a bitrate")
        return self

    @model_validator(mode="after")
    def _check_bit_rates(self) -> Self:
        if self.data_bitrate is not None and (self.bitrate is None or self.data_bitrate < self.bitrate):
            raise ValueError("data_bitrate: expected at least the bitrate, and only on a bus with a bitrate")
        return self


class CanModelBus(CanFamily, ModelBus[CanMessage]):
    """A CAN bus whose medium is `CanBusModel`."""

    messages: ClassVar[tuple[type, ...]] = (CanFrame, CanError, BusState, FaultNote, CanControl, BitRate)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS
    settings: CanSettings

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
        """Arguments of `can.Bus(...)` to join from outside; None where that is not possible."""
        return None
