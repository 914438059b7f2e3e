"""A state that is a function of events by their instants, whatever order they arrive in.

In real time a message about the past may arrive after the state has gone on without it, such as a segment of pulses
that is over already.  Then the state goes back to the event before it and takes everything again in its order, so that
it is the same in the end as if nothing had been late.
"""

from collections.abc import Callable
from typing import Final, Generic, NamedTuple, Protocol, Self, TypeVar

MOST_EVENTS: Final = 128
"""Events that can be taken again.  A segment goes back over those since the one before it on its wire."""


class Timed(Protocol):
    """A state that changes by itself between events."""

    now_ns: int
    """The instant up to which, with it, everything has happened."""

    def advance(self, to_ns: int) -> None:
        """Let everything happen up to and including an instant; nothing if that is over."""

    def look(self) -> None:
        """Judge the present instant, after an event."""

    def copy(self) -> Self:
        """Return the same state, independent of this one."""


S = TypeVar("S", bound=Timed)


class _Event(NamedTuple, Generic[S]):
    when_ns: int
    change: Callable[[S], None]
    source: str | None
    after: S


class Replay(Generic[S]):
    """A state, and the events that led to it."""

    def __init__(self, state: S) -> None:
        self.state = state
        """The state by all that is known.  It is another object after each event."""
        self._oldest = state.copy()
        self._events: list[_Event[S]] = []

    def happen(self, when_ns: int, change: Callable[[S], None]) -> None:
        """Let an event happen at an instant, after those of the same instant."""
        when_ns = max(when_ns, self._oldest.now_ns)
        index = len(self._events)
        while index and self._events[index - 1].when_ns > when_ns:
            index -= 1
        self._insert(index, when_ns, change, None, is_back=self.state.now_ns > when_ns)

    def begin(self, when_ns: int, change: Callable[[S], None], source: str) -> None:
        """Let something of a source begin that lasts until its next one, after other events of the same instant.

        What a source begins twice at one instant has lasted for no time, and only the last one counts.  Nothing begins
        before what the source began earlier.
        """
        events = self._events
        last = next((at for at in reversed(range(len(events))) if events[at].source == source), -1)
        when_ns = max(when_ns, self._oldest.now_ns, events[last].when_ns if last >= 0 else when_ns)
        index = len(events)
        while index > last + 1 and events[index - 1].when_ns > when_ns:
            index -= 1
        if last >= 0 and events[last].when_ns == when_ns:
            index = last
        self._insert(index, when_ns, change, source, is_back=self.state.now_ns >= when_ns)

    def _insert(
        self, index: int, when_ns: int, change: Callable[[S], None], source: str | None, *, is_back: bool
    ) -> None:
        now_ns, later = self.state.now_ns, self._events[index:]
        del self._events[index:]
        if later or is_back:
            self.state = (self._events[-1].after if self._events else self._oldest).copy()
        self._take(when_ns, change, source)
        for event in later:
            if event.source is None or (event.source, event.when_ns) != (source, when_ns):
                self._take(event.when_ns, event.change, event.source)
        self.state.advance(now_ns)
        if len(self._events) > MOST_EVENTS:
            self._oldest = self._events[MOST_EVENTS // 2].after
            del self._events[: MOST_EVENTS // 2 + 1]

    def _take(self, when_ns: int, change: Callable[[S], None], source: str | None) -> None:
        state = self.state
        state.advance(when_ns - 1)
        state.now_ns = max(state.now_ns, when_ns)
        change(state)
        state.look()
        self._events.append(_Event(when_ns, change, source, state.copy()))
