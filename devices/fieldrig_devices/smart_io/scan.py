"""The scan of inputs: a sample in each PERIOD, and a new level after DEBOUNCE equal samples (PAML-082, PAML-083).

Sampling is computed only while a level differs from what was accepted: the first sample after an edge is at the next
multiple of the period since the start, so the result is that of a scan that never rests.  Pulses say when they rose and
fell, so the samples of those that arrive late, on a busy host, are made up for.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

from fieldrig.clock import Alarm, Clock, S
from fieldrig_devices.smart_io.terminals import Terminals

LATEST_NS: Final = 1 * S
"""The samples of pulses that are later than this are not made up for; a ring has failed by then."""


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
        self._watchers = [partial(self._on_edge, bit) for bit in range(len(inputs))]
        self._changing: set[int] = set()
        """The inputs that are sampled, by their bits."""
        self._origin_ns = self._sampled_ns = self._due_ns = 0
        self.edge_ns = 0
        """Instant of the last edge."""
        self._timer = Alarm(self._clock)
        self.value = 0
        """The levels that were accepted."""

    def start(self) -> None:
        """Accept the present levels, and scan from now on."""
        self._origin_ns = self._sampled_ns = self._clock.now_ns()
        self.value = sum(self._terminals.level(name) << bit for bit, name in enumerate(self._inputs))
        for bit, name in enumerate(self._inputs):
            self._terminals.watch(name, self._watchers[bit])
            self._on_edge(bit)

    def stop(self) -> None:
        """Scan no longer."""
        for name, watcher in zip(self._inputs, self._watchers, strict=True):
            self._terminals.unwatch(name, watcher)
        self._changing.clear()
        self._counts = [0] * len(self._inputs)
        self._timer.stop()

    def _on_edge(self, bit: int) -> None:
        self.edge_ns = max(self._terminals.began_ns(self._inputs[bit]), self._origin_ns)
        if bit not in self._changing and self._is_changing(bit, self.edge_ns):
            self._changing.add(bit)
            if not self._timer.is_set:
                self._go_on(self.edge_ns)

    def _is_changing(self, bit: int, now_ns: int) -> bool:
        name, accepted = self._inputs[bit], bool(self.value >> bit & 1)
        return self._terminals.level_at(name, now_ns) is not accepted or self._terminals.is_moving_at(name, now_ns)

    def _go_on(self, from_ns: int) -> None:
        """Take the samples from an instant on that are over already, and wait for the next one."""
        from_ns = max(from_ns, self._clock.now_ns() - LATEST_NS)
        # Samples are at multiples of the period since the start, wherever the edge was; the next one after a sample
        # that a busy host took late is a whole period behind it.
        periods = -(-(from_ns - self._origin_ns) // self._period_ns)
        due_ns = max(self._origin_ns + periods * self._period_ns, self._sampled_ns + self._period_ns)
        while self._changing and due_ns < self._clock.now_ns():
            self._take(due_ns)
            due_ns += self._period_ns
        if self._changing and not self._timer.is_set:
            self._due_ns = due_ns
            self._timer.at(due_ns, self._on_sample)

    def _on_sample(self) -> None:
        """Take the sample that is due; that of a level which does not say since when it holds is one of now."""
        has_instants = all(self._terminals.has_instants(self._inputs[bit]) for bit in self._changing)
        self._take(self._due_ns if has_instants else self._clock.now_ns())
        self._go_on(self._sampled_ns)

    def _take(self, now_ns: int) -> None:
        """Take a sample of the inputs that change."""
        self._sampled_ns = now_ns
        before = self.value
        for bit in tuple(self._changing):
            self._sample(bit, now_ns)
            if not self._is_changing(bit, now_ns):
                self._changing.remove(bit)
        if self.value != before:
            self._on_change()

    def _sample(self, bit: int, now_ns: int) -> None:
        if self._terminals.level_at(self._inputs[bit], now_ns) is bool(self.value >> bit & 1):
            self._counts[bit] = 0
            return
        self._counts[bit] += 1
        if self._counts[bit] >= self._debounce:
            self._counts[bit] = 0
            self.value ^= 1 << bit
