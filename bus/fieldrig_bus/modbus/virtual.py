"""`modbus.virtual`: Modbus between devices in virtual time, as TCP (no baud) or as a serial line (with one)."""

from collections.abc import Hashable
from typing import Any, ClassVar

from pydantic import Field

from fieldrig.bus import BusModel, Time
from fieldrig.clock import MS
from fieldrig_bus.modbus.faults import MODELS, ModbusFault
from fieldrig_bus.modbus.framing import LineTiming, Mode
from fieldrig_bus.modbus.kind import FAULTS, CharacterSettings, ModbusBus
from fieldrig_bus.modbus.line_model import LineModel
from fieldrig_bus.modbus.model import ModbusModel
from fieldrig_bus.modbus.outside import UnitId
from fieldrig_bus.serial.message import Format


class ModbusVirtualSettings(CharacterSettings):
    baud: int | None = Field(
        default=None, ge=300, le=10_000_000, description="baud rate of a serial line; null: no delay, as on TCP"
    )
    mode: Mode = Field(default="rtu", description="framing on the line")
    response_timeout_ms: int = Field(
        default=1000, ge=1, description="response timeout, after which the line is free for the next request"
    )
    servers: list[UnitId] = Field(
        default_factory=list,
        description="units that devices of the rig use and an attached member, such as a test, serves",
    )
    faults: list[ModbusFault] = Field(default_factory=list, description=FAULTS)

    def leads_to(self, what: str, value: Hashable) -> bool:
        return value in self.servers


class ModbusVirtual(ModbusBus):
    about: ClassVar[str] = "Modbus between devices, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})
    fault_models = MODELS

    def __init__(self, name: str, settings: ModbusVirtualSettings) -> None:
        super().__init__(name, settings)

    def model(self) -> BusModel[Any]:
        settings: ModbusVirtualSettings = self.settings
        if settings.baud is None:
            return ModbusModel()
        return LineModel(settings.timing(settings.mode, settings.baud), settings.response_timeout_ms * MS)

    @property
    def line(self) -> tuple[LineTiming, Format] | None:
        settings: ModbusVirtualSettings = self.settings
        baud = settings.baud
        return None if baud is None else (settings.timing(settings.mode, baud), settings.format(baud))
