"""`SerialBus`: what all serial lines have in common, and their settings."""

from collections.abc import Mapping
from typing import Any, ClassVar, Final, Literal

from pydantic import Field

from fieldrig.bus import ModelBus, Time
from fieldrig.clock import US
from fieldrig.settings import Settings
from fieldrig_bus.net import HubSettings
from fieldrig_bus.serial import codec
from fieldrig_bus.serial.faults import (
    MODELS,
    TCP_MODELS,
    SerialEffects,
    SerialFault,
    SerialTcpEffects,
    SerialTcpFault,
)
from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage, check_interest, check_sent
from fieldrig_bus.serial.model import SerialModel
from fieldrig_bus.serial.urlhandler import register

register()

FAULTS: Final = "faults from the start"


class SerialSettings(Settings):
    baud: int = Field(
        default=9600, ge=1, le=10_000_000, description="bits per second, for each end until it sets another rate"
    )
    data_bits: Literal[5, 6, 7, 8] = 8
    parity: Literal["N", "E", "O"] = "N"
    stop_bits: Literal[1, 2] = 1
    paced: bool = Field(
        default=True, description="true: bytes take the time of their format; false: they arrive at once"
    )
    chunk_us: int = Field(
        default=2000, ge=1, description="longest duration of a chunk in which bytes arrive; a longer byte arrives alone"
    )
    garbling: bool = Field(default=False, description="an end whose format differs from the sender's receives garbage")

    @property
    def format(self) -> Format:
        return Format(self.baud, self.data_bits, self.parity, self.stop_bits)


class SerialHubSettings(HubSettings, SerialSettings):
    pass


class LineFaults(Settings):
    faults: list[SerialFault] = Field(default_factory=list, description=FAULTS)


class TcpLineFaults(Settings):
    faults: list[SerialTcpFault] = Field(default_factory=list, description=FAULTS)


class SerialBus(ModelBus[SerialMessage]):
    """A serial line; all serial buses are subclasses."""

    family: ClassVar[str] = "serial"
    notes_faults: ClassVar[bool] = True
    messages: ClassVar[tuple[type, ...]] = (bytes, ControlLines, Format, Break)
    times: ClassVar[frozenset[Time]] = frozenset({"real", "virtual"})
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS
    settings: Any

    encode = staticmethod(codec.encode)
    decode = staticmethod(codec.decode)
    show = staticmethod(codec.show)
    check = staticmethod(check_sent)
    check_interest = staticmethod(check_interest)

    def model(self) -> SerialModel:
        settings: SerialSettings = self.settings
        return SerialModel(settings.format, settings.chunk_us * US, settings.paced, settings.garbling)

    def effects(self) -> SerialEffects:
        effects = SerialTcpEffects if self.fault_models is TCP_MODELS else SerialEffects
        return effects(self.settings.faults)
