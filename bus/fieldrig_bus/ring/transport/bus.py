"""Base of the rings in real time: the master's process hosts the centre, and the others reach it.

A process becomes the master's when a device in it begins to listen as master.  Until then, and whenever that process is
gone, stations hear nothing; their own supervision detects it.
"""

import asyncio
import logging
from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from pydantic import Field

from fieldrig.bus import Attachment, DirectBus, Time
from fieldrig.clock import MS
from fieldrig.settings import Settings
from fieldrig_bus.ring.faults import MASTER
from fieldrig_bus.ring.impostors import Impostors
from fieldrig_bus.ring.transport.centre import Centre, Spokes
from fieldrig_bus.ring.transport.rack import Rack

log = logging.getLogger(__name__)

M = TypeVar("M")


class StarSettings(Settings):
    """Settings that every ring in real time has."""

    realtime: bool = Field(
        default=False,
        description="ask the system for SCHED_FIFO for every process with an end (root, or CAP_SYS_NICE)",
    )
    patience_ms: int = Field(
        default=0,
        ge=0,
        le=10_000,
        description="how long late answers are tolerated on a busy host, while the last one is repeated; 0: not at all",
    )


class Line(Protocol):
    """A process's connection to the centre in another process.  It retries, and connects the rack once it succeeds."""

    def close(self) -> None:
        """Disconnect, and stop trying."""


class Carrier(Protocol):
    """The connection between the processes of a ring: shared memory, or Zenoh."""

    most_behind: int
    """Cycles that it keeps for a process that stands still."""

    def reach(self, at: Attachment, rack: Rack[Any]) -> Line:
        """Begin to look for the centre in another process."""

    def hold(self, at: Attachment, centre: Centre) -> Spokes:
        """Become reachable for other processes.  BusError, with its remedy, if that is not possible."""


class StarEnd(Generic[M]):
    """One device's end of a ring."""

    def __init__(self, bus: "StarBus[M]", at: Attachment) -> None:
        self._bus, self.at = bus, at
        self.patience_ns = bus.settings.patience_ms * MS
        """Time for which late answers are tolerated (`PatientLink`)."""
        self._rack, self._member = bus.rack(at), at.member
        self._impostors = Impostors()

    def send(self, message: M) -> None:
        """Leave a telegram, which is bytes, or send a message of the master."""
        if isinstance(message, bytes):
            self._rack.leave(self._member, message)
        elif self._bus.master == self._member and self._bus.star is not None:
            self._bus.star.send(message)
        else:
            self._impostors.drop(self._member)

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        """Listen as the master, as a station, or, without interest, as an observer."""
        if interest is not None and MASTER in interest:
            self._bus.begin_star(self.at, handler)
        else:
            self._bus.begin_station(self.at, handler, interest)


class StarBus(DirectBus[M]):
    """A ring in real time.  A kind of ring says what its centre and its racks are, and what carries it."""

    times: ClassVar[frozenset[Time]] = frozenset({"real"})
    carrier: Carrier
    settings: StarSettings

    def __init__(self, name: str, settings: Any) -> None:
        super().__init__(name, settings)
        self.star: Centre | None = None
        self.master: str | None = None
        self._rack: Rack[Any] | None = None
        self._line: Line | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    @abstractmethod
    def make_centre(self, at: Attachment, handler: Callable[[Any], None], loop: asyncio.AbstractEventLoop) -> Centre:
        """The centre, in the process of the master `at`."""

    @abstractmethod
    def make_rack(self, loop: asyncio.AbstractEventLoop) -> Rack[Any]:
        """The rack of a process."""

    def rack(self, at: Attachment) -> Rack[Any]:
        """The rack of the process of `at`, which is this one."""
        if self._rack is None:
            self._rack = self.make_rack(self._running_loop())
        return self._rack

    async def open(self, at: Attachment) -> StarEnd[M]:
        self._loop = asyncio.get_running_loop()
        return StarEnd(self, at)

    def begin_star(self, at: Attachment, handler: Callable[[Any], None]) -> None:
        """A device listens as the master: host the centre."""
        if self.star is not None:
            if self.master == at.member:
                self.star.handler = handler
            else:
                log.warning("%s: %s is the master already, not %s", self.name, self.master, at.member)
            return
        star = self.make_centre(at, handler, self._running_loop())
        star.open(self.carrier.hold(at, star))
        self.star, self.master = star, at.member
        self._drop_line()
        rack = self.rack(at)
        star.open_local(at.process, rack.on_spread)
        rack.connect(partial(star.announce, at.process), partial(star.take, at.process))
        at.serve(star)

    def begin_station(self, at: Attachment, handler: Callable[[Any], None], interest: Sequence[Any] | None) -> None:
        """A device listens as a station or observer: reach the centre, if it is in another process."""
        rack = self.rack(at)
        rack.listen(at, handler, interest)
        if self.star is None and self._line is None:
            self._line = self.carrier.reach(at, rack)

    async def close(self, member: str) -> None:
        if member == self.master and self.star is not None:
            self.star.close()
            self.star = self.master = None
            if self._rack is not None:
                self._rack.disconnect()
        if self._rack is not None:
            self._rack.forget(member)
            if not len(self._rack):
                self._drop_line()

    def _running_loop(self) -> asyncio.AbstractEventLoop:
        assert self._loop is not None
        return self._loop

    def _drop_line(self) -> None:
        line, self._line = self._line, None
        if line is not None:
            line.close()
