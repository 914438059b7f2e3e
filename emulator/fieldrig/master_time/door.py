"""A program's own end of a bus in virtual time, without a socket: it sends, and waits for what arrives."""

from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar

from fieldrig.errors import RigError
from fieldrig.master_time.active import waiting_scheduler
from fieldrig.master_time.member import Member

M = TypeVar("M")


class Door(Generic[M]):
    """An end of one bus for members of the block."""

    def __init__(
        self,
        bus: str,
        prefix: str,
        interest: Sequence[object] | None = None,
        is_wanted: Callable[[Any], bool] | None = None,
    ) -> None:
        """Join the bus of this name as `prefix:1`, or the next free number.

        Messages for which `is_wanted` is false are dropped.  RigError outside of a block, or for an unknown bus.
        """
        scheduler = waiting_scheduler()
        if scheduler is None:
            raise RigError(
                "this thread is not in virtual time",
                "use `with virtual_time(rig):`; in real time connect to an address, which `fieldrig help` shows",
            )
        self._scheduler, self._bus = scheduler, bus
        self._arrived: deque[tuple[int, M]] = deque()
        self._waiting: deque[Member] = deque()
        self._is_wanted = is_wanted
        number = 1
        while scheduler.rig.clients.has(f"{prefix}:{number}", bus):
            number += 1
        self.member = f"{prefix}:{number}"
        self._node = scheduler.rig.clients.join(self.member, bus)
        self._link = self._node.link(bus)
        self._link.on_receive(self._on_message, interest)

    def send(self, message: M) -> None:
        """Send now.  TypeError or ValueError for a message that the bus cannot carry."""
        self._link.send(message)

    def receive(self, timeout_s: float | None) -> tuple[int, M] | None:
        """Return the next message with its instant; None after the time-out."""
        scheduler, arrived = self._scheduler, self._arrived
        until_ns = scheduler.until(timeout_s)
        while not arrived:
            if until_ns is not None and scheduler.rig.now_ns >= until_ns:
                if timeout_s == 0:
                    scheduler.count_read()
                break
            scheduler.wait(until_ns, self._waiting, hears_rig=True)
        return arrived.popleft() if arrived else None

    def close(self) -> None:
        """Leave the bus; what was sent before still goes out."""
        self._link.on_receive(lambda _: None, [])

    def _on_message(self, message: M) -> None:
        if self._is_wanted is None or self._is_wanted(message):
            self._arrived.append((self._node.clock.now_ns(), message))
            self._scheduler.wake_one(self._waiting)
