"""Base of the CAN buses whose medium exists outside the rig: each member has an end of its own.

An end sends `BURST` frames in one iteration of the event loop and the rest in the next ones, so that a burst does not
overrun the receive buffers of the others: neither vcan nor UDP makes a sender wait.
"""

import asyncio
import logging
import socket
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from random import Random
from typing import Any, ClassVar, Final

from pydantic import Field

from fieldrig.bus import Attachment, DirectBus, Time
from fieldrig.clock import MS
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.can.acceptance import ERRORS, STATE, Filters, filters_of, wants, wants_own
from fieldrig_bus.can.codec import CanMessage
from fieldrig_bus.can.family import CanFamily
from fieldrig_bus.can.faulty_link import MODELS, FaultyLink, LinkFault
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BusState, CanError, FaultNote

log = logging.getLogger(__name__)

BURST: Final = 64
LONGEST_QUEUE: Final = 10_000
RETRY_NS: Final = 1 * MS
"""Time after which a full transmit queue is tried again, as the kernel does not report that it has room.  At 1 Mbit/s a
frame takes an eighth of this."""


class DirectEnd(ABC):
    """One member's link, around a non-blocking socket."""

    def __init__(self, at: Attachment, sock: socket.socket) -> None:
        self.at, self.socket = at, sock
        self.handler: Callable[[CanFrame], None] | None = None
        self.notices = frozenset[str]()
        """The words of `acceptance` for notices of the controller, as far as the medium reports them."""
        self._loop = asyncio.get_running_loop()
        self._queue: deque[CanFrame] = deque()
        self._sent = 0  # in this iteration of the event loop
        self._is_coming_back = False
        self._loop.add_reader(sock, self._on_readable)

    def send(self, message: CanMessage) -> None:
        if type(message) is not CanFrame:
            log.debug("%s: the medium is configured outside the rig; not sent: %r", self.at.member, message)
            return
        if not self._queue and self._sent < BURST and self.transmit(message):
            self._sent += 1
        elif len(self._queue) < LONGEST_QUEUE:
            self._queue.append(message)
        else:
            log.debug("%s has %d frames waiting; dropped %r", self.at.member, LONGEST_QUEUE, message)
        if not self._is_coming_back:
            self._come_back()

    def on_receive(self, handler: Callable[[CanFrame], None], interest: Sequence[object] | None = None) -> None:
        self.handler = handler
        self.notices = frozenset(word for word in (ERRORS, STATE) if wants(interest, word))
        self.listen(filters_of(interest), wants_own(interest))

    def close(self) -> None:
        self._queue.clear()
        self._loop.remove_reader(self.socket)
        self.socket.close()

    @abstractmethod
    def transmit(self, frame: CanFrame) -> bool:
        """Hand a frame to the medium.  False if the medium has no room at the moment."""

    @abstractmethod
    def listen(self, filters: Filters | None, with_own: bool) -> None:
        """Pass only the frames that `acceptance` selects."""

    @abstractmethod
    def receive(self) -> None:
        """Read one message and deliver its frame if it is one and of interest.  OSError as the socket raises it."""

    def _on_readable(self) -> None:
        try:
            for _ in range(BURST):
                self.receive()
        except BlockingIOError:
            pass
        except OSError as fault:  # such as a network device that was set down; it may come up again
            log.warning("%s: %s", self.at.member, fault)

    def _come_back(self) -> None:
        self._is_coming_back = True
        if self._sent:
            self._loop.call_soon(self._on_turn)
        else:  # the medium has no room
            self.at.clock.call_at(self.at.clock.now_ns() + RETRY_NS, self._on_turn)

    def _on_turn(self) -> None:
        self._sent, self._is_coming_back = 0, False
        queue = self._queue
        while queue and self._sent < BURST and self.transmit(queue[0]):
            queue.popleft()
            self._sent += 1
        if queue or self._sent:
            self._come_back()


class CanDirectSettings(Settings):
    """Settings that all of these buses have."""

    faults: list[LinkFault] = Field(default=[], description="faults at each device's own end, from the start")


class CanDirectBus(CanFamily, DirectBus[CanMessage]):
    """A CAN bus whose medium exists outside the rig."""

    times: ClassVar[frozenset[Time]] = frozenset({"real"})
    messages: ClassVar[tuple[type, ...]] = (CanFrame, CanError, BusState, FaultNote)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS
    settings: CanDirectSettings

    def __init__(self, name: str, settings: Any) -> None:
        super().__init__(name, settings)
        self._ends: dict[str, DirectEnd] = {}

    @abstractmethod
    def end(self, at: Attachment) -> DirectEnd:
        """A new end.  BusError, with its remedy, if the medium is not available."""

    @abstractmethod
    def python_can(self) -> dict[str, object]:
        """Arguments of `can.Bus(...)` to join from outside."""

    async def open(self, at: Attachment) -> Link[Any]:
        end = self._ends[at.member] = self.end(at)
        return FaultyLink(at, end, self.settings.faults, Random(f"{at.seed}/{self.name}/{at.member}"))

    async def close(self, member: str) -> None:
        end = self._ends.pop(member, None)
        if end is not None:
            end.close()
