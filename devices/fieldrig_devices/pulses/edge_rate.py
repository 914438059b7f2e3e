"""The frequency of single edges: from the time between the last two, and lower when the next one does not come."""

from math import ceil

from fieldrig.clock import S


class EdgeRate:
    """Measures the pulses of one digital wire."""

    def __init__(self) -> None:
        self._last_ns: int | None = None
        self._hz = 0.0
        self._sign = 1

    def edge(self, now_ns: int, is_reverse: bool = False) -> float:
        """Take a rising edge, and return the frequency in Hz, negative backwards; 0 after the first one."""
        last_ns, self._last_ns = self._last_ns, now_ns
        self._hz = S / max(now_ns - last_ns, 1) if last_ns is not None else 0.0
        self._sign = -1 if is_reverse else 1
        return self._sign * self._hz

    def drops_ns(self, by_hz: float) -> int | None:
        """Return when the frequency has dropped by more than this, if no edge comes before; None if it cannot."""
        if self._last_ns is None or self._hz <= by_hz:
            return None
        return self._last_ns + ceil(S / (self._hz - by_hz))

    def end(self) -> None:
        """Forget the frequency: the edges have stopped."""
        self._hz = 0.0

    def hz_at(self, now_ns: int) -> float:
        """Return the frequency in Hz at an instant, negative backwards."""
        if self._last_ns is None or not self._hz:
            return 0.0
        silent_ns = now_ns - self._last_ns
        return self._sign * (min(self._hz, S / silent_ns) if silent_ns > 0 else self._hz)
