"""The carrier of a ring over shared memory: both ends of it, where the system has what they need."""

import os
import socket
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from fieldrig.bus import Attachment
from fieldrig.errors import BusError
from fieldrig_bus.ring.transport.centre import MOST_BEHIND, Centre
from fieldrig_bus.ring.transport.rack import Rack

LINUX: Final = "fieldrig_bus.ring.transport.shm"
"""The module of both ends, which only Linux can import."""
EXTRA_SLOTS: Final = 16
"""Room for messages that come back between two cycles."""
_NEEDS = "it needs Linux; use ring.zenoh elsewhere"


def is_available() -> bool:
    """True if this system has memfd, eventfd and sequenced packets."""
    return hasattr(os, "memfd_create") and hasattr(os, "eventfd") and hasattr(socket, "SOCK_SEQPACKET")


class ShmCarrier:
    """Connects the processes of one ring over shared memory.

    BusError where the system has none, once the ring starts: a rig file can be checked on any system.
    """

    def __init__(self, name: str, most_behind: int = MOST_BEHIND) -> None:
        """`name` is that of the bus."""
        self.name, self.most_behind = name, most_behind
        self._slots = most_behind + EXTRA_SLOTS

    def reach(self, at: Attachment, rack: Rack[Any]) -> Any:
        return self._ends().ShmLine(self._path(at), at.process, rack, self._slots)

    def hold(self, at: Attachment, centre: Centre) -> Any:
        return self._ends().ShmSpokes(self._path(at), centre, self._slots)

    def _ends(self) -> Any:
        if not is_available():
            raise BusError(f"{self.name}: this system has no memfd and eventfd", _NEEDS)
        return import_module(LINUX)

    def _path(self, at: Attachment) -> Path:
        return at.path(f"{self.name}.ring")
