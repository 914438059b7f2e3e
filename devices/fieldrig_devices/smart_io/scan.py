"""The scan of inputs: a sample in each PERIOD, and a new level after DEBOUNCE equal samples (PAML-082, PAML-083).

Sampling is computed only while a level differs from what was accepted: the first sample after an edge is at the next
multiple of the period since the start, so the result is that of a scan that never rests.
"""

from collections.abc import Callable, Sequence
from functools import partial

from fieldrig.clock import Clock, Timer
from fieldrig_devices.smart_io.terminals import Terminals


class InputScan:
    """Some inputs that are sampled together; their levels are the bits of one number, the first input is bit 0."""

    def __init__(
        self,
        clock: Clock,
        terminals: Terminals,
        inputs: Sequence[str],
        period_ns: int,
        debounce: int,
        on_change: Callable[[], None],
    ) -> None:
        self._clock, self._terminals, self._inputs = clock, terminals, inputs
        self._period_ns, self._debounce, self._on_change = period_ns, debounce, on_change
        self._counts = [0] * len(inputs)
        self._watchers = [partial(self._on_edge, place) for place in range(len(inputs))]
        self._changing: set[int] = set()
        """The inputs that are sampled, by their bits."""
        self._origin_ns = self._sampled_ns = 0
        self.edge_ns = 0
        """Instant of the last edge."""
        self._timer: Timer | None = None
        self.value = 0
        """The levels that were accepted."""

    def start(self) -> None:
        """Accept the present levels, and scan from now on."""
        self._origin_ns = self._sampled_ns = self._clock.now_ns()
        self.value = sum(self._terminals.level(name) << place for place, name in enumerate(self._inputs))
        for place, name in enumerate(self._inputs):
            self._terminals.watch(name, self._watchers[place])
            self._on_edge(place)

    def stop(self) -> None:
        """Scan no longer."""
        for name, watcher in zip(self._inputs, self._watchers, strict=True):
            self._terminals.unwatch(name, watcher)
        self._changing.clear()
        self._counts = [0] * len(self._inputs)
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _on_edge(self, place: int) -> None:
        self.edge_ns = self._clock.now_ns()
        if place not in self._changing and self._is_changing(place):
            self._changing.add(place)
            if self._timer is None:
                self._wait()

    def _is_changing(self, place: int) -> bool:
        name = self._inputs[place]
        return self._terminals.level(name) != self.value >> place & 1 or self._terminals.is_moving(name)

    def _wait(self) -> None:
        periods = -(-(self._clock.now_ns() - self._origin_ns) // self._period_ns)
        due_ns = self._origin_ns + periods * self._period_ns
        self._timer = self._clock.call_at(max(due_ns, self._sampled_ns + self._period_ns), self._on_sample)

    def _on_sample(self) -> None:
        self._timer = None
        self._sampled_ns = self._clock.now_ns()
        before = self.value
        for place in tuple(self._changing):
            self._sample(place)
            if not self._is_changing(place):
                self._changing.remove(place)
        if self._changing:
            self._wait()
        if self.value != before:
            self._on_change()

    def _sample(self, place: int) -> None:
        if self._terminals.level(self._inputs[place]) == self.value >> place & 1:
            self._counts[place] = 0
            return
        self._counts[place] += 1
        if self._counts[place] >= self._debounce:
            self._counts[place] = 0
            self.value ^= 1 << place
