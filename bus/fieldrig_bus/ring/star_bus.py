"""What the rings in real time have in common: the master's process hosts the centre, the others reach it.

Which process that is shows when a device there begins to listen as master.  Until then, and whenever that process is
gone, drives hear nothing; their own watch tells them so.
"""

import asyncio
import logging
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, ClassVar, Protocol

from pydantic import Field

from fieldrig.bus import Attachment, DirectBus, Time
from fieldrig.clock import MS
from fieldrig_bus.ring import message
from fieldrig_bus.ring.faults import MASTER, MODELS
from fieldrig_bus.ring.message import Answers, Cycle, Mdt, Mst, RingMessage
from fieldrig_bus.ring.star import Spokes, Star
from fieldrig_bus.ring.star_rack import Rack
from fieldrig_bus.ring.virtual import RingSettings

log = logging.getLogger(__name__)


class RingStarSettings(RingSettings):
    realtime: bool = Field(
        default=False,
        description="ask the system for SCHED_FIFO for every process with an end (root, or CAP_SYS_NICE)",
    )
    patience_ms: int = Field(
        default=0,
        ge=0,
        le=10_000,
        description="how long a computer that is busy is forgiven: for a late AT the last one stands in; 0: never",
    )


class Line(Protocol):
    """A process's way to the centre in another one.  It keeps trying, and connects the rack whenever it is there."""

    def close(self) -> None: ...


class RingEnd:
    """One device's end."""

    def __init__(self, bus: "RingStar", at: Attachment) -> None:
        self._bus, self.at = bus, at
        self.patience_ns = bus.settings.patience_ms * MS
        """Devices at both ends forgive as much."""
        self._rack, self._member = bus.rack(at), at.member

    def send(self, message: RingMessage) -> None:
        if isinstance(message, bytes):
            self._rack.leave(self._member, message)
        elif self._bus.master == self._member and self._bus.star is not None:
            self._bus.star.send(message)
        else:
            log.debug("%s is not the master of the ring", self._member)

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        if interest is not None and MASTER in interest:
            self._bus.begin_star(self.at, handler)
        else:
            self._bus.begin_station(self.at, handler, interest)


class RingStar(DirectBus[RingMessage]):
    times: ClassVar[frozenset[Time]] = frozenset({"real"})
    family: ClassVar[str] = "ring"
    messages: ClassVar[tuple[type, ...]] = (Mst, Mdt, Cycle, Answers, bytes)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS
    settings: RingStarSettings

    encode = staticmethod(message.encode)
    decode = staticmethod(message.decode)
    show = staticmethod(message.show)
    check = staticmethod(message.check_sent)
    check_interest = staticmethod(message.check_interest)

    def __init__(self, name: str, settings: Any) -> None:
        super().__init__(name, settings)
        self.star: Star | None = None
        self.master: str | None = None
        self._rack: Rack | None = None
        self._line: Line | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    @abstractmethod
    def reach(self, at: Attachment, rack: Rack) -> Line:
        """Begin to look for the centre in another process."""

    @abstractmethod
    def hold(self, at: Attachment, star: Star) -> Spokes:
        """Be reachable for other processes.  BusError, with its remedy, if that can't be had."""

    def rack(self, at: Attachment) -> Rack:
        """That of the process of `at`, which is this one."""
        if self._rack is None:
            self._rack = Rack(self.name, self._running_loop())
        return self._rack

    async def open(self, at: Attachment) -> RingEnd:
        self._loop = asyncio.get_running_loop()
        return RingEnd(self, at)

    def begin_star(self, at: Attachment, handler: Callable[[Any], None]) -> None:
        if self.star is not None:
            if self.master == at.member:
                self.star.handler = handler
            else:
                log.warning("%s: %s is the master already, not %s", self.name, self.master, at.member)
            return
        star = Star(self.name, at, self.settings, handler, self._running_loop())
        star.open(self.hold(at, star))
        self.star, self.master = star, at.member
        self._drop_line()
        rack = self.rack(at)
        star.open_local(at.process, rack.on_spread)
        rack.connect(partial(star.announce, at.process), partial(star.take, at.process))
        at.serve(star)

    def begin_station(self, at: Attachment, handler: Callable[[Any], None], interest: Sequence[Any] | None) -> None:
        rack = self.rack(at)
        rack.listen(at, handler, interest)
        if self.star is None and self._line is None:
            self._line = self.reach(at, rack)

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
