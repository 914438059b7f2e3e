"""Stops a client whose messages wait for a slow medium, until most of them are sent."""

from collections.abc import Callable
from typing import Final

from fieldrig.bus import Hub
from fieldrig.clock import MS, Alarm
from fieldrig_bus.net import Connection

MOST_WAITING: Final = 64
"""Messages of a client that may wait for the medium; as many as a few ms of a full CAN bus."""
LOOK_NS: Final = 5 * MS
"""Time after which the medium is looked at again."""


class Backlog:
    """Call `look` after everything that the client has sent."""

    def __init__(
        self,
        hub: Hub,
        member: str,
        read_on: Callable[[bool], None],
        on_full: Callable[[], None],
        most: int = MOST_WAITING,
        ahead: Callable[[], int] = lambda: 0,
    ) -> None:
        """`read_on` stops the client or lets it go on; `on_full` is called whenever it is stopped.

        `ahead` returns how many of its messages are not on the medium yet, as they were read ahead of its time.
        """
        self._ahead = ahead
        self._hub, self._member, self._read_on, self._on_full, self._most = hub, member, read_on, on_full, most
        self._timer = Alarm(hub.clock)
        self._was_full = False

    @property
    def is_full(self) -> bool:
        """True while the client sends more than the medium carries."""
        return self._hub.waiting(self._member) + self._ahead() >= self._most

    def look(self) -> None:
        was_full, is_full = self._was_full, self.is_full
        self._was_full = is_full
        if is_full:
            self._timer.after(LOOK_NS, self.look)
        if is_full and not was_full:
            self._on_full()
        if is_full is not was_full:
            self._read_on(not is_full)

    def close(self) -> None:
        self._timer.stop()


def backlog_of(
    client: Connection, hub: Hub, member: str, most: int = MOST_WAITING, ahead: Callable[[], int] = lambda: 0
) -> Backlog:
    """Return the backlog of a connection, which counts in the figures of its service."""

    def note() -> None:
        client.server.door.reached.note("clients that had to wait", f"{member} has {most} messages waiting")

    return Backlog(hub, member, client.read_on, note, most, ahead)
