"""`serial.pty`: a serial line with one end on a pseudo-terminal, for programs that open a serial device.

The pty has a stable link, `serial/NAME` in the run folder unless `path` names another place.  The baud rate of the
client applies from the next time that it sends.
Left out, because a pty does not have them: control lines (the other end sees DTR and RTS on), breaks, and whether a
client is connected; data bits, parity and stop bits are the configured ones.
"""

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

from pydantic import Field

from fieldrig.bus import Hub, Port
from fieldrig.device import Tool
from fieldrig_bus.net import join_as_client
from fieldrig_bus.pty import Pty
from fieldrig_bus.serial.end import LineEnd
from fieldrig_bus.serial.line import SerialBus, SerialHubSettings


class SerialPtySettings(SerialHubSettings):
    path: str | None = Field(
        default=None, description="path of the link to the pty; a relative path is in the run folder"
    )


class SerialPty(SerialBus):
    about: ClassVar[str] = "a serial line with one end on a pseudo-terminal"

    def __init__(self, name: str, settings: SerialPtySettings) -> None:
        super().__init__(name, settings)

    @property
    def path(self) -> str:
        return self.settings.path or f"serial/{self.name}"

    def ports(self) -> Sequence[Port]:
        return (PtyPort(self.path, self.settings),)

    def tools(self, run: Path) -> list[Tool]:
        path, baud = shlex.quote(str(run / self.path)), self.settings.baud
        return [
            Tool("terminal", f"python -m serial.tools.miniterm {path} {baud}"),
            Tool("over TCP", f"socat {path},rawer TCP-LISTEN:7000,bind=127.0.0.1,reuseaddr"),
        ]


class PtyPort(Port):
    def __init__(self, path: str, settings: SerialPtySettings) -> None:
        self._path, self._settings = path, settings
        self._pty: Pty | None = None
        self._end: LineEnd | None = None
        self._is_following = False

    async def open(self, hub: Hub) -> None:
        pty = Pty(hub.path(self._path))
        pty.open(self._on_client)
        self._pty = pty
        self._is_following = pty.set_baud(self._settings.baud)
        _, link = join_as_client(hub, "pty")
        self._end = LineEnd(link, hub.clock, self._settings.format, self._settings.paced)
        self._end.on_room = pty.read_on
        link.on_receive(pty.write)

    async def close(self) -> None:
        if self._end is not None:
            self._end.purge()
        if self._pty is not None:
            self._pty.close()
            self._pty = None

    def _on_client(self, data: bytes) -> None:
        if self._end is None or self._pty is None:
            return
        if self._is_following and (baud := self._pty.baud()):  # 0: the client has closed the pty
            self._end.set_format(replace(self._end.form, baud=baud))
        self._end.send(data)
