"""`modbus.virtual`: Modbus between devices in virtual time, as TCP (no baud) or as a serial line (with one).

Its addresses are where a master in a block of `virtual_time` connects, as it would to a `modbus.tcp` or a `modbus.rtu`.
"""

from collections.abc import Callable, Hashable, Sequence
from pathlib import Path
from typing import Any, ClassVar, Self

from pydantic import Field, model_validator

from fieldrig.bus import BusModel, Hub, Port, Time
from fieldrig.clock import MS
from fieldrig.device import WayIn
from fieldrig.link import Link
from fieldrig.settings import Address, RunPath
from fieldrig_bus.modbus.faults import MODELS, ModbusFault
from fieldrig_bus.modbus.framing import LineTiming, Mode
from fieldrig_bus.modbus.framing_ascii import AsciiFramer
from fieldrig_bus.modbus.framing_rtu import RtuFramer
from fieldrig_bus.modbus.kind import FAULTS, CharacterSettings, ModbusBus
from fieldrig_bus.modbus.line_model import LineModel
from fieldrig_bus.modbus.line_place import ModbusLineSettings, Session
from fieldrig_bus.modbus.line_ports import PtyPort, TcpLinePort
from fieldrig_bus.modbus.line_session import LineSession
from fieldrig_bus.modbus.model import ModbusModel
from fieldrig_bus.modbus.outside import UnitId
from fieldrig_bus.modbus.tcp import ModbusTcpSettings, TcpPort
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
    listen: Address | None = Field(
        default=None, description="host:port where a master in virtual time connects, for TCP or for the line's bytes"
    )
    pty: RunPath | None = Field(
        default=None, description="path in the run folder where a master in virtual time opens the line"
    )
    faults: list[ModbusFault] = Field(default_factory=list, description=FAULTS)

    @model_validator(mode="after")
    def _check_ways_in(self) -> Self:
        if self.pty is not None and self.baud is None:
            raise ValueError("pty: only a serial line has one; expected baud beside it")
        if self.pty is not None and self.listen is not None:
            raise ValueError("expected pty or listen, as a line has one other end")
        return self

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

    def ports(self) -> Sequence[Port]:
        settings: ModbusVirtualSettings = self.settings
        if settings.baud is None:
            tcp = None if settings.listen is None else ModbusTcpSettings(listen=settings.listen)
            return () if tcp is None else (TcpPort(tcp),)
        if settings.pty is not None:
            return (self.program_port(settings.pty),)
        return () if settings.listen is None else (TcpLinePort(self._outside(listen=settings.listen), self.session),)

    def ways_in(self, run: Path) -> list[WayIn]:
        settings: ModbusVirtualSettings = self.settings
        if settings.pty is not None:
            return [WayIn(f"Modbus {settings.mode.upper()}", str(run / settings.pty))]
        protocol = "Modbus TCP" if settings.baud is None else f"Modbus {settings.mode.upper()} over TCP"
        return [] if settings.listen is None else [WayIn(protocol, settings.listen)]

    def program_port(self, url: str) -> Port:
        """Return a port for a master in virtual time that opens the line by its name."""
        return PtyPort(self._outside(pty=url), self.session)

    def session(self, hub: Hub, link: Link[Any], write: Callable[[bytes], None]) -> Session:
        """Return the servers' end of the line; the model has the time that frames take."""
        settings: ModbusVirtualSettings = self.settings
        assert settings.baud is not None
        timing = settings.timing(settings.mode, settings.baud)
        is_rtu = settings.mode == "rtu"
        framer = RtuFramer(timing, is_strict=False, is_burst=False) if is_rtu else AsciiFramer(timing, is_burst=False)
        return LineSession(hub.clock, link, write, framer, timing, is_paced=False)

    def _outside(self, **way: str) -> ModbusLineSettings:
        return ModbusLineSettings.model_validate({**way, "baud": self.settings.baud})

    @property
    def line(self) -> tuple[LineTiming, Format] | None:
        settings: ModbusVirtualSettings = self.settings
        baud = settings.baud
        return None if baud is None else (settings.timing(settings.mode, baud), settings.format(baud))
