"""A serial port that programs open by its path: a pty, or its like in virtual time."""

import sys
from collections.abc import Callable
from contextlib import suppress
from typing import Protocol

from fieldrig.bus import Hub, TerminalHub
from fieldrig.errors import BusError

INSTEAD = "use TCP instead: `listen: 127.0.0.1:PORT`, or a bus of the kind serial.tcp or serial.rfc2217"


class Terminal(Protocol):
    """The calls of a serial port."""

    def open(self, on_bytes: Callable[[bytes], None], on_presence: Callable[[bool], None] | None = None) -> None: ...

    def read_on(self, is_wanted: bool) -> None: ...

    def write(self, data: bytes) -> None: ...

    def forget(self) -> None: ...

    def baud(self) -> int | None: ...

    def set_baud(self, baud: int) -> bool: ...

    def close(self) -> None: ...


def terminal(hub: Hub, name: str) -> Terminal:
    """Return the serial port at a path in the run folder of the rig.  BusError where the system has no ptys."""
    if isinstance(hub, TerminalHub):
        made: Terminal = hub.terminal(name)
        return made
    if sys.platform != "win32":
        with suppress(ImportError):
            from fieldrig_bus.pty import Pty

            return Pty(hub.path(name))
    raise BusError(f"{name}: this system has no pseudo-terminals", INSTEAD)
