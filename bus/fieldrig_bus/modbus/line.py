"""`modbus.rtu` and `modbus.ascii`: devices on a serial line whose outside end is a master, or, with `servers`, servers.

The line is a pty under a stable name, a real port, or a TCP connection that carries its bytes.  Frames take the time of
the line's baud rate in both directions (a real port takes it itself).  A frame is written in one piece at the instant
at which its last character would have been sent: no program can guarantee that less than 1.5 characters pass between
two writes, and a strict receiver would drop a frame that is written in pieces.

With `servers` the master is in the rig.  Its exchanges with units of the rig take the line's time as well, though the
outside does not see them.
Left out: removing the echo of two-wire adapters.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from fieldrig.bus import BusModel, Hub, Port, Time
from fieldrig.clock import MS
from fieldrig.device import RUN, WayIn
from fieldrig.link import Link
from fieldrig.outside.addresses import split_address
from fieldrig_bus.modbus.faults import LINE_MODELS
from fieldrig_bus.modbus.framing import LineFramer, LineTiming, Mode
from fieldrig_bus.modbus.framing_ascii import AsciiFramer
from fieldrig_bus.modbus.framing_rtu import FRAME_TIMEOUT_NS, RtuFramer, request_size, response_size
from fieldrig_bus.modbus.kind import ModbusBus
from fieldrig_bus.modbus.line_client import LineClient
from fieldrig_bus.modbus.line_model import LineModel
from fieldrig_bus.modbus.line_place import ModbusLineSettings, Session
from fieldrig_bus.modbus.line_ports import DiallingPort, PtyPort, TcpLinePort
from fieldrig_bus.modbus.line_session import LineSession
from fieldrig_bus.modbus.model import ModbusModel
from fieldrig_bus.serial.message import Format


class ModbusRtuSettings(ModbusLineSettings):
    data_bits: Literal[8] = 8
    gaps: Literal["strict", "tolerant"] | None = Field(
        default=None,
        description="strict: silences of 1.5 and 3.5 characters as in V1.02, 2.5.1.1; tolerant: a frame in pieces is "
        "whole when its CRC is right (see framing_rtu); null: strict on a pty, tolerant elsewhere",
    )
    frame_timeout_ms: int = Field(
        default=FRAME_TIMEOUT_NS // MS,
        ge=1,
        le=60_000,
        description="with tolerant gaps: a frame that is incomplete this long after its last byte is dropped",
    )

    @model_validator(mode="after")
    def _check_frame_timeout(self) -> Self:
        if self.is_strict and "frame_timeout_ms" in self.model_fields_set:
            raise ValueError("frame_timeout_ms has no effect with strict gaps; expected gaps: tolerant beside it")
        return self

    @property
    def is_strict(self) -> bool:
        return self.gaps == "strict" if self.gaps is not None else self.pty is not None


class ModbusAsciiSettings(ModbusLineSettings):
    data_bits: Literal[7, 8] = 7


class _ModbusLine(ModbusBus):
    times: ClassVar[frozenset[Time]] = frozenset({"real", "virtual"})
    fault_models = LINE_MODELS
    mode: ClassVar[Mode]

    @property
    def line(self) -> tuple[LineTiming, Format]:
        settings: ModbusLineSettings = self.settings
        return settings.timing(self.mode, settings.baud), settings.format(settings.baud)

    @property
    def timing_at_port(self) -> LineTiming | None:
        return None if self.settings.servers else self.line[0]

    def model(self) -> BusModel[Any]:
        settings: ModbusLineSettings = self.settings
        if not settings.servers:
            return ModbusModel(self.mode)
        timing, is_paced = settings.timing(self.mode, settings.baud), settings.port is None
        return LineModel(timing, settings.response_timeout_ms * MS, settings.turnaround_ms * MS, is_paced)

    def ports(self) -> Sequence[Port]:
        settings: ModbusLineSettings = self.settings
        if settings.pty is not None:
            return (PtyPort(settings, self.session),)
        if settings.port is not None:
            from fieldrig_bus.modbus.line_uart import UartPort  # pyserial, for a rig with a real port alone

            return (UartPort(self.name, settings, self.session),)
        if settings.dial is not None:
            return (DiallingPort(self.name, settings, self.session),)
        return (TcpLinePort(settings, self.session),)

    def session(self, hub: Hub, link: Link[Any], write: Callable[[bytes], None]) -> Session:
        settings: ModbusLineSettings = self.settings
        timing = settings.timing(self.mode, settings.baud)
        if settings.servers:
            return LineClient(hub.clock, link, write, self.framer(timing), settings.servers)
        return LineSession(hub.clock, link, write, self.framer(timing), timing, is_paced=settings.port is None)

    def program_port(self, url: str) -> Port:
        """Return a port for a master in virtual time that opens the line by its name."""
        return PtyPort(self.settings.model_copy(update={"pty": url}), self.session)

    def framer(self, timing: LineTiming) -> LineFramer:
        raise NotImplementedError

    def ways_in(self, run: Path) -> list[WayIn]:
        """Return the place where a master connects.  The other end of a real port is a different machine."""
        settings: ModbusLineSettings = self.settings
        protocol = f"Modbus {self.mode.upper()}"
        if settings.servers:
            return []
        if settings.pty is not None:
            return [WayIn(protocol, str(run / settings.pty))]
        return [] if settings.listen is None else [WayIn(f"{protocol} over TCP", settings.listen)]

    def pymodbus(self) -> str | None:
        settings: ModbusLineSettings = self.settings
        framer = f"framer=FramerType.{self.mode.upper()}"
        if settings.servers:
            return None
        if settings.listen is not None:
            host, port = split_address(settings.listen)
            name, arguments = "ModbusTcpClient", f"{host!r}, port={port}, {framer}"
        elif settings.pty is not None:  # it always carries 8 bits without parity: see `mbpoll`
            path = f"{RUN}/{settings.pty}"
            name, arguments = (
                "ModbusSerialClient",
                f"{path!r}, {framer}, baudrate={settings.baud}, parity='N', bytesize=8",
            )
        else:
            return None
        return (
            f"from pymodbus import FramerType; from pymodbus.client import {name}; c = {name}({arguments}); c.connect()"
        )


class ModbusRtu(_ModbusLine):
    about: ClassVar[str] = "Modbus RTU on a pty, a serial port, or over TCP"
    mode: ClassVar[Mode] = "rtu"

    def __init__(self, name: str, settings: ModbusRtuSettings) -> None:
        super().__init__(name, settings)

    def framer(self, timing: LineTiming) -> LineFramer:
        settings: ModbusRtuSettings = self.settings
        size_of = response_size if settings.servers else request_size
        return RtuFramer(
            timing,
            settings.is_strict,
            is_burst=settings.port is None,
            size_of=size_of,
            frame_timeout_ns=settings.frame_timeout_ms * MS,
        )

    def mbpoll(self) -> tuple[Sequence[str], str] | None:
        settings: ModbusRtuSettings = self.settings
        if settings.pty is None or settings.servers:
            return None
        # A pty always carries 8 bits without parity, and tcsetattr(3) fails for any other format.
        return ("-m", "rtu", "-b", str(settings.baud), "-P", "none", "-s", "1"), f"{RUN}/{settings.pty}"


class ModbusAscii(_ModbusLine):
    about: ClassVar[str] = "Modbus ASCII on a pty, a serial port, or over TCP"
    mode: ClassVar[Mode] = "ascii"

    def __init__(self, name: str, settings: ModbusAsciiSettings) -> None:
        super().__init__(name, settings)

    def framer(self, timing: LineTiming) -> LineFramer:
        return AsciiFramer(timing, is_burst=self.settings.port is None)
