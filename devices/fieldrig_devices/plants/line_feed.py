"""The web that passes the line: from a wire with its speed, or from the encoder of the axis that drives it."""

from typing import Final

from fieldrig.clock import S
from fieldrig_bus.wires import Signal

FASTEST_M_PER_S: Final = 1e3  # limit for the value of a wire
_SHORTEST_S: Final = 0.001  # so that a step of counts in no time still counts
_MOST_COUNTS: Final = 1e15  # beyond this a float cannot count in ones


class LineFeed:
    """The speed of the line, and the web that has passed."""

    def __init__(self, m_per_count: float | None) -> None:
        """The wire carries a speed in m/s if `m_per_count` is None."""
        self._m_per_count = m_per_count
        self._signal: Signal | None = None
        self._taken_ns = 0
        self._taken_counts: float | None = None

    def take(self, signal: Signal) -> None:
        """Take a new signal; call `passed_m` for the time before it first."""
        self._signal = signal
        if self._taken_counts is None:
            self._taken_counts = _within(float(signal.value), _MOST_COUNTS)

    def speed(self, now_ns: int) -> float:
        """Return the speed in m/s; 0 for an encoder that is published step by step."""
        signal = self._signal
        if signal is None:
            return 0.0
        if self._m_per_count is None:
            return _within(_value(signal, now_ns), FASTEST_M_PER_S)
        return _within(signal.speed_at(now_ns) * self._m_per_count, FASTEST_M_PER_S)

    def is_still(self, now_ns: int) -> bool:
        signal = self._signal
        if signal is None:
            return True
        if signal.is_moving:
            return False
        return _value(signal, now_ns) == (0.0 if self._m_per_count is None else self._taken_counts)

    def passed_m(self, now_ns: int) -> float:
        """Return the web in m that has passed since the last call."""
        since_ns, self._taken_ns = self._taken_ns, now_ns
        signal = self._signal
        if signal is None or self._taken_counts is None:
            return 0.0
        seconds = (now_ns - since_ns) / S
        if self._m_per_count is None:
            passed_m = (_value(signal, since_ns) + _value(signal, now_ns)) / 2 * seconds
        else:
            before, self._taken_counts = self._taken_counts, _value(signal, now_ns)
            passed_m = (self._taken_counts - before) * self._m_per_count
        return _within(passed_m, FASTEST_M_PER_S * max(seconds, _SHORTEST_S))


def _value(signal: Signal, now_ns: int) -> float:
    return _within(float(signal.at(now_ns)), _MOST_COUNTS)


def _within(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)
