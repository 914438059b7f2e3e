"""The trace of a program: every n-th row of a recording, with a trigger, as an oscilloscope shows them.

The rows are those of a recording of the kernel, one for each cycle.  Without a trigger the recorder keeps the latest
samples until it is stopped.  With one it keeps `before` samples, waits for the trigger, and takes no more when its
memory of `depth` samples is full.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

from fieldrig.device import Value

MOST_SAMPLES: Final = 100_000
MOST_VALUES: Final = 32

Row = Sequence[Value | None]
"""The values at the end of a cycle; None where there is none."""
Sample = tuple[int, tuple[Value | None, ...]]
"""The instant of a row, and its values without the one of the trigger."""


class Edge(Enum):
    RISING = "rising"
    FALLING = "falling"
    ANY = "any"


@dataclass(frozen=True, slots=True)
class Trigger:
    """A value that crosses `level`: rising from at most the level to above it, falling from above it to at most it."""

    place: int
    """The place of the value in a row."""
    edge: Edge
    level: float = 0.0
    before: int = 0
    """Samples to keep from before the trigger."""


class RecorderState(Enum):
    WAITING = "waiting"
    RECORDING = "recording"
    FULL = "full"


class Recorder:
    """One trace.  `take` is called with the row of every cycle."""

    def __init__(self, width: int, *, every: int = 1, depth: int = 1_000, trigger: Trigger | None = None) -> None:
        """Keep the first `width` values of each row; depth and `before` are in samples, `every` in cycles.

        ValueError if a number is out of range.
        """
        if not 1 <= width <= MOST_VALUES:
            raise ValueError(f"expected 1 to {MOST_VALUES} values to record, got {width}")
        if not 1 <= depth <= MOST_SAMPLES:
            raise ValueError(f"expected a depth of 1 to {MOST_SAMPLES} samples, got {depth}")
        if every < 1:
            raise ValueError(f"expected a sample in every cycle or less often, got every {every}")
        if trigger is not None and not 0 <= trigger.before < depth:
            raise ValueError(f"expected 0 to {depth - 1} samples before the trigger, got {trigger.before}")
        self._width, self._every, self._depth, self._trigger = width, every, depth, trigger
        self._until_next = 0
        self._was_above: bool | None = None
        self._samples: deque[Sample] = deque(maxlen=depth)
        self.state = RecorderState.RECORDING if trigger is None else RecorderState.WAITING
        self.triggered_ns: int | None = None
        self.taken = 0
        """Samples since the start, of which the latest `depth` are kept."""

    def take(self, now_ns: int, row: Row) -> None:
        """Look at the trigger, and keep the row if a sample is due."""
        if self.state is RecorderState.FULL:
            return
        if self.state is RecorderState.WAITING:
            self._look_at_trigger(now_ns, row)
        self._until_next -= 1
        if self._until_next > 0:
            return
        self._until_next = self._every
        self._samples.append((now_ns, tuple(row[: self._width])))
        self.taken += 1
        if self._trigger is None:
            return
        if self.state is RecorderState.WAITING:
            while len(self._samples) > self._trigger.before:
                self._samples.popleft()
        elif len(self._samples) == self._depth:
            self.state = RecorderState.FULL

    def samples(self, after: int = 0) -> list[Sample]:
        """Return the kept samples, as (time in ns, values), without the first `after` of all that were taken."""
        first_kept = self.taken - len(self._samples)
        return list(self._samples)[max(after - first_kept, 0) :]

    def _look_at_trigger(self, now_ns: int, row: Row) -> None:
        trigger = self._trigger
        assert trigger is not None
        value = row[trigger.place]
        if value is None:
            return
        is_above = not isinstance(value, str) and value > trigger.level
        was_above, self._was_above = self._was_above, is_above
        if was_above is None or was_above is is_above:
            return
        if trigger.edge is Edge.ANY or (trigger.edge is Edge.RISING) is is_above:
            self.state, self.triggered_ns = RecorderState.RECORDING, now_ns
