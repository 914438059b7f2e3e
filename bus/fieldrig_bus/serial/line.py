"""Serial lines from device to device: `serial.virtual` in virtual time, `serial.line` in real time through a hub.

Every serial bus is such a line; those of the neighbouring files also have a port for an outside client.  In a block of
`virtual_time` a program opens a line as `fieldrig://NAME`, with its control lines and breaks, or a `serial.virtual` at
the addresses that it would have in real time.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

from pydantic import Field

from fieldrig.bus import Port, Time
from fieldrig.device import WayIn
from fieldrig.settings import Address, RunPath
from fieldrig_bus.serial.bus import LineFaults, SerialBus, SerialHubSettings, SerialSettings, TcpLineFaults
from fieldrig_bus.serial.faults import TCP_MODELS
from fieldrig_bus.serial.program import ProgramPort
from fieldrig_bus.serial.pty import PtyPort, SerialPtySettings
from fieldrig_bus.serial.tcp import SerialTcpSettings, TcpPort

_HERE = frozenset({"path", "listen", "faults"})


class SerialVirtualSettings(SerialSettings, TcpLineFaults):
    path: RunPath | None = Field(
        default=None, description="path in the run folder where a program in virtual time opens the line"
    )
    listen: Address | None = Field(default=None, description="host:port where a program in virtual time connects")


class SerialVirtual(SerialBus):
    about: ClassVar[str] = "a serial line between devices, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})
    fault_models = TCP_MODELS

    def __init__(self, name: str, settings: SerialVirtualSettings) -> None:
        super().__init__(name, settings)

    def ports(self) -> Sequence[Port]:
        settings: SerialVirtualSettings = self.settings
        line = settings.model_dump(include=settings.model_fields_set - _HERE)
        ports: list[Port] = []
        if settings.path is not None:
            ports.append(PtyPort(settings.path, SerialPtySettings.model_validate(line)))
        if settings.listen is not None:
            ports.append(TcpPort(SerialTcpSettings.model_validate({**line, "listen": settings.listen})))
        return ports

    def ways_in(self, run: Path) -> list[WayIn]:
        settings: SerialVirtualSettings = self.settings
        places = (settings.path and str(run / settings.path), settings.listen)
        return [WayIn("serial line", place) for place in places if place]

    def program_port(self, url: str) -> Port:
        """Return a port for a program in virtual time that opens the line by its name."""
        return ProgramPort(url, self.settings)


class SerialLineSettings(SerialHubSettings, LineFaults):
    pass


class SerialLine(SerialBus):
    about: ClassVar[str] = "a serial line between devices, in real time"

    def __init__(self, name: str, settings: SerialLineSettings) -> None:
        super().__init__(name, settings)

    def program_port(self, url: str) -> Port:
        """Return a port for a program in virtual time that opens the line by its name."""
        return ProgramPort(url, self.settings)
