"""`modbus.virtual`: Modbus between devices in virtual time, as TCP (no baud) or as a serial line (with one)."""

from collections.abc import Hashable
from typing import Any, ClassVar

from pydantic import Field

from fieldrig.bus import BusModel, Time
from fieldrig.clock import MS
from fieldrig_bus.modbus.framing import Mode
from fieldrig_bus.modbus.kind import CharacterSettings, ModbusBus
from fieldrig_bus.modbus.line_model import LineModel
from fieldrig_bus.modbus.model import ModbusModel
from fieldrig_bus.modbus.outside import UnitId


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

    def leads_to(self, what: str, value: Hashable) -> bool:
        return value in self.servers


class ModbusVirtual(ModbusBus):
    about: ClassVar[str] = "Modbus between devices, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})

    def __init__(self, name: str, settings: ModbusVirtualSettings) -> None:
        super().__init__(name, settings)

    def model(self) -> BusModel[Any]:
        settings: ModbusVirtualSettings = self.settings
        if settings.baud is None:
            return ModbusModel()
        return LineModel(settings.timing(settings.mode, settings.baud), settings.response_timeout_ms * MS)
