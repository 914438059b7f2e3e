"""The multi-comparator: it learns when references pass, and starts routines at these times (PAML-550 to PAML-562)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

from fieldrig_devices.pam.pipes.block import Block, is_same, nearest

Slope = Literal["POSITIVE", "NEGATIVE", "ZERO_MAXIMUM", "ZERO_MINIMUM"]
Mode = Literal["IMMEDIATE", "NEXT_PERIOD"]
ComparatorState = Literal["deactivated", "wait origin", "tracing"]

MOST_REFERENCES: Final = 8
"""References of a trace in one cycle (PAML-553)."""


@dataclass(frozen=True, slots=True)
class Reference:
    """A place in the flow: a value that is passed with a slope, or an extremum, whose value does not matter."""

    slope: Slope
    mode: Mode
    position: float


class Watch:
    """A reference that is looked for in the flow; it is found once."""

    def __init__(self, reference: Reference, period: float | None) -> None:
        self.reference = reference
        self._waits_for_period = reference.mode == "NEXT_PERIOD" and period is not None

    def finds(self, before: float, last: float, step: float, period: float | None) -> bool:
        """True if the way from `last` by `step` meets the reference; `before` is the step in front of it."""
        if self._waits_for_period:
            if period is None or 0 <= last + step < period:
                return False
            self._waits_for_period = False
        match self.reference.slope:
            case "ZERO_MAXIMUM":
                return before > 0 >= step
            case "ZERO_MINIMUM":
                return before < 0 <= step
            case "POSITIVE":
                return step > 0 and 0 < self._ahead(last, period, 1) <= step
        return step < 0 and 0 < self._ahead(last, period, -1) <= -step

    def way_from(self, last: float, step: float, period: float | None) -> float:
        """Return the part of a step up to the reference that it meets; all of it up to an extremum."""
        match self.reference.slope:
            case "POSITIVE":
                return self._ahead(last, period, 1)
            case "NEGATIVE":
                return -self._ahead(last, period, -1)
        return step

    def _ahead(self, last: float, period: float | None, direction: int) -> float:
        """Return the way from a value to the reference in a direction, the next time round if it is behind."""
        way = (self.reference.position - last) * direction
        return way if period is None else way % period or period


class Trace:
    """A channel with one reference at a time, and the times that it has learned."""

    def __init__(self) -> None:
        self.routine: Callable[[], None] = lambda: None
        self.active: Watch | None = None
        self.delay_s = 0.0
        self._learned: dict[int, tuple[Reference, float]] = {}
        """The times by the numbers of their references in the cycle (G-34)."""
        self._number = -1
        """Number of the reference in its cycle."""

    def begin(self) -> None:
        """A cycle begins: references are installed again, from the first."""
        self._number, self.active = -1, None

    def forget(self) -> None:
        self.begin()
        self._learned.clear()

    def install(self, reference: Reference, delay_s: float, period: float | None) -> None:
        """Look for a reference; more than eight in a cycle are refused."""
        if self._number + 1 < MOST_REFERENCES:
            self._number += 1
            self.active, self.delay_s = Watch(reference, period), delay_s

    def time_of(self, reference: Reference) -> float | None:
        """Return the time after the origin at which the present reference passes; None if it has to be learned."""
        known = self._learned.get(self._number)
        return known[1] if known is not None and known[0] == reference else None

    def fire(self, elapsed_s: float | None) -> None:
        """The reference has passed, for the first time `elapsed_s` after the origin; its routine starts."""
        if elapsed_s is not None and self.active is not None:
            self._learned[self._number] = self.active.reference, elapsed_s
        self.active = None
        self.routine()


class MultiComparator(Block):
    """A comparator whose flow passes unchanged; `learn` and `execute` begin a cycle, which the origin starts."""

    def __init__(self, origin: Reference, value_period: float | None) -> None:
        super().__init__()
        self.origin, self.value_period = origin, value_period
        self.origin_routine: Callable[[], None] = lambda: None
        self.traces: list[Trace] = []
        self.state: ComparatorState = "deactivated"
        self.is_executing = False
        self._origin_watch = Watch(origin, value_period)
        self._last: float | None = None
        self._step = 0.0
        self._is_still = False
        """True if the last value was the same as the one before."""
        self._periods = 0
        self._has_fired = False

    @property
    def is_at_rest(self) -> bool:
        return self.state != "tracing" and self._is_still

    def learn(self) -> None:
        self._begin(is_executing=False)

    def execute(self) -> None:
        self._begin(is_executing=True)

    def _begin(self, *, is_executing: bool) -> None:
        self.is_executing, self.state = is_executing, "wait origin"
        self._origin_watch = Watch(self.origin, self.value_period)
        for trace in self.traces:
            trace.begin()

    def start(self, period_s: float) -> None:
        super().start(period_s)
        self._last, self._step, self._is_still = None, 0.0, False

    def stop(self) -> None:
        """The learned times are lost with the history of the block (PAML-409)."""
        super().stop()
        self.state = "deactivated"
        for trace in self.traces:
            trace.forget()

    def transform(self, value: float) -> float:
        place = value if self.value_period is None else value % self.value_period
        last, self._last = self._last, place
        self._is_still = is_same(place, last)
        if last is None:
            return value
        before, self._step = self._step, nearest(place - last, self.value_period)
        if self.state == "wait origin":
            self._look_for_origin(before, last)
        elif self.state == "tracing":
            self._trace(before, last)
        return value

    def _look_for_origin(self, before: float, last: float) -> None:
        """Begin at the origin; references in the rest of its step pass at once."""
        if not self._origin_watch.finds(before, last, self._step, self.value_period):
            return
        self.state, self._periods, self._has_fired = "tracing", 0, False
        self.origin_routine()
        way = self._origin_watch.way_from(last, self._step, self.value_period)
        self._fire_found(before, last + way, self._step - way)

    def _trace(self, before: float, last: float) -> None:
        self._periods += 1
        if self._has_fired and all(trace.active is None for trace in self.traces):
            self.state = "deactivated"  # all references have fired (PAML-560)
        else:
            self._fire_found(before, last, self._step)

    def _fire_found(self, before: float, last: float, step: float) -> None:
        elapsed_s = self._periods * self.period_s
        for trace in self.traces:
            if (watch := trace.active) is None:
                continue
            learned = trace.time_of(watch.reference) if self.is_executing else None
            if learned is not None:
                if elapsed_s >= learned - trace.delay_s - 1e-9:
                    self._has_fired = True
                    trace.fire(None)
            elif watch.finds(before, last, step, self.value_period):
                self._has_fired = True
                trace.fire(elapsed_s)
