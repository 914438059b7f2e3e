"""Faults, conditions and events of a rig, with their instants, for the time line under the scope and for triggers.

A process looks twice a second whether a fault has begun or ended (`fieldrig.control.notices`), and does not say when it
did.  So each has a time span: it happened after the first instant and not later than the second.
"""

from collections import deque
from collections.abc import Callable
from itertools import islice
from typing import Any, Final, NamedTuple

from fieldrig.clock import MS
from fieldrig.control.notices import FAULT, PERIOD_S, taken

MOST: Final = 500
SPAN_NS: Final = round(PERIOD_S * 1000) * MS


class Event(NamedTuple):
    after_ns: int
    at_ns: int
    sort: str
    """`fault`, `condition` or `event`."""
    part: str
    text: str
    is_over: bool


class Events:
    """The latest events.  `on_event` is called with each."""

    def __init__(self, now_ns: Callable[[], int]) -> None:
        """`now_ns` returns the present instant of the rig, as far as it is known."""
        self._now_ns = now_ns
        self._kept: deque[Event] = deque(maxlen=MOST)
        self.count = 0
        """Number of all events so far."""
        self.on_event: list[Callable[[Event], None]] = []

    def take_notice(self, _name: str, message: Any) -> None:
        """Take what is published at `notice/*`."""
        notice = taken(message)
        if notice is not None:
            sort = "fault" if notice.key.startswith(FAULT) else "condition"
            self._add(sort, notice.part, notice.text, notice.is_over)

    def take_event(self, _name: str, message: Any) -> None:
        """Take what is published at `event`, such as the restart of a process."""
        match message:
            case {"what": str(what), **rest}:
                part = next((value for value in rest.values() if isinstance(value, str)), "")
                self._add("event", part, what, False)

    def since(self, count: int) -> list[Event]:
        """The events after the first `count`, as far as they are kept."""
        return list(islice(self._kept, max(len(self._kept) - (self.count - count), 0), None))

    def _add(self, sort: str, part: str, text: str, is_over: bool) -> None:
        now_ns = self._now_ns()
        event = Event(max(now_ns - SPAN_NS, 0), now_ns, sort, part, text, is_over)
        self._kept.append(event)
        self.count += 1
        for on_event in tuple(self.on_event):
            on_event(event)
