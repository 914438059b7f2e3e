"""`serial.pty`: a serial line with one end on a pseudo-terminal, for programs that open a serial device.

The pty has a stable link, `serial/NAME` in the run folder unless `path` names another place.  The baud rate of the
client applies from the next time that it sends.

The other end sees DTR and RTS on while a program has the pty open, as at a serial port, whether the program writes or
only listens.  They go off when the last program has closed it, or was killed, after the line has transmitted what it
wrote.  They stay off for `OFF_NS`, even if another program opens the pty at once.  What that one writes waits, so a
modem hangs up before it gets a command, and what the modem says to that does not reach the new program.
Left out, because a pty does not have them: control lines that the client sets or reads, and breaks; data bits, parity
and stop bits are the configured ones.
"""

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

from pydantic import Field

from fieldrig.bus import Hub, Port
from fieldrig.clock import MS, Alarm
from fieldrig.device import Tool, WayIn
from fieldrig.settings import RunPath
from fieldrig_bus.net import join_as_client
from fieldrig_bus.serial.bus import LineFaults, SerialBus, SerialHubSettings, SerialSettings
from fieldrig_bus.serial.end import OFF, LineEnd
from fieldrig_bus.terminal import Terminal, terminal

OFF_NS = 250 * MS
"""Shortest time for which DTR and RTS are off, five times the default of a modem's register S25."""
OFF_STEPS = 10
"""Timers in which this time passes, so that a host that stands still for longer does not use it up at once: the modem
hangs up between them.
"""
AFTER_LAST_NS = 1 * MS
"""Time from the last byte of a program until its lines go off."""


class SerialPtySettings(SerialHubSettings, LineFaults):
    path: RunPath | None = Field(default=None, description="path of the link to the pty, in the run folder")


class SerialPty(SerialBus):
    about: ClassVar[str] = "a serial line with one end on a pseudo-terminal"

    def __init__(self, name: str, settings: SerialPtySettings) -> None:
        super().__init__(name, settings)

    @property
    def path(self) -> str:
        return self.settings.path or f"serial/{self.name}"

    def ports(self) -> Sequence[Port]:
        return (PtyPort(self.path, self.settings),)

    def ways_in(self, run: Path) -> list[WayIn]:
        return [WayIn("serial line", str(run / self.path))]

    def tools(self, run: Path) -> list[Tool]:
        path, baud = shlex.quote(str(run / self.path)), self.settings.baud
        return [
            Tool("terminal", f"python -m serial.tools.miniterm {path} {baud}"),
            Tool("over TCP", f"socat {path},rawer TCP-LISTEN:7000,bind=127.0.0.1,reuseaddr"),
        ]


class PtyPort(Port):
    def __init__(self, path: str, settings: SerialSettings) -> None:
        self._path, self._settings = path, settings
        self._pty: Terminal | None = None
        self._end: LineEnd | None = None
        self._is_following = False
        self._is_present = False
        self._has_room = True

    async def open(self, hub: Hub) -> None:
        self._dropping = Alarm(hub.clock)
        """Set while the lines of a client that has gone are going off, and until they may go on again."""
        _, link = join_as_client(hub, "pty")
        self._link = link
        self._end = LineEnd(link, hub.clock, self._settings.format, self._settings.paced)
        self._end.on_room = self._on_room
        self._end.hang_up()
        pty = terminal(hub, self._path)
        pty.open(self._on_client, self._on_presence)
        self._pty = pty
        self._is_following = pty.set_baud(self._settings.baud)
        link.on_receive(self._on_line)

    async def close(self) -> None:
        if self._end is not None:
            self._dropping.stop()
            self._end.purge()
        if self._pty is not None:
            self._pty.close()
            self._pty = None

    def _on_line(self, data: bytes) -> None:
        if self._pty is not None and not self._dropping.is_set:
            self._pty.write(data)

    def _on_client(self, data: bytes) -> None:
        if self._end is None or self._pty is None:
            return
        if self._is_following and (baud := self._pty.baud()):  # 0: the client has closed the pty
            self._end.set_format(replace(self._end.form, baud=baud))
        self._end.send(data)

    def _on_presence(self, is_present: bool) -> None:
        self._is_present = is_present
        if not self._dropping.is_set and is_present:
            self._plug_in()
        elif not self._dropping.is_set:
            self._drop_when_sent()
            self._read_if_possible()

    def _plug_in(self) -> None:
        if self._end is not None:
            self._end.plug_in()

    def _drop_when_sent(self) -> None:
        assert self._end is not None
        self._dropping.at(self._end.sent_ns + AFTER_LAST_NS, self._drop)

    def _drop(self) -> None:
        assert self._end is not None
        if self._end.is_sending:  # the host was late, so the line is as well
            self._drop_when_sent()
            return
        self._stay_off(OFF_STEPS)  # first, so that what the lines cause finds them going off
        self._end.set_lines(OFF)

    def _stay_off(self, steps: int) -> None:
        if steps:
            self._dropping.after(OFF_NS // OFF_STEPS, lambda: self._stay_off(steps - 1))
            return
        if self._is_present:
            self._plug_in()
        self._read_if_possible()

    def _on_room(self, has_room: bool) -> None:
        self._has_room = has_room
        self._read_if_possible()

    def _read_if_possible(self) -> None:
        if self._pty is not None:
            self._pty.read_on(self._has_room and not self._dropping.is_set)
