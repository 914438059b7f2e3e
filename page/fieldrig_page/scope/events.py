"""Faults, conditions and events of a rig, with their instants, for the time line under the scope and for triggers.

A process looks whether a fault has begun or ended when one is added or cleared, and twice a second
(`fieldrig.control.notices`).  So each has two instants: it happened after the first one, and not later than the second.
"""

from collections import deque
from collections.abc import Callable
from itertools import islice
from typing import Any, Final, NamedTuple

from fieldrig.control import events
from fieldrig.control.notices import FAULT, span_of, taken

MOST: Final = 500


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
            self._add(sort, notice.part, notice.text, span_of(message), is_over=notice.is_over)

    def take_event(self, _name: str, message: Any) -> None:
        """Take what is published at `event`, such as the restart of a process."""
        event = events.taken(message)
        if event is not None:
            self._add("event", event.process, events.in_words(event), None, is_over=False)

    def since(self, count: int) -> list[Event]:
        """The events after the first `count`, as far as they are kept."""
        return list(islice(self._kept, max(len(self._kept) - (self.count - count), 0), None))

    def _add(self, sort: str, part: str, text: str, span: tuple[int, int] | None, *, is_over: bool) -> None:
        after_ns, at_ns = span or (self._now_ns(), self._now_ns())
        event = Event(after_ns, at_ns, sort, part, text, is_over)
        self._kept.append(event)
        self.count += 1
        for on_event in tuple(self.on_event):
            on_event(event)
