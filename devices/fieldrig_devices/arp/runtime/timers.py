"""The six timers of STIM and TIM (manual 5.10)."""

from fieldrig_devices.arp import fixed
from fieldrig_devices.arp.runtime.card import Card

_NS_OF_RAW = 1_000_000  # one raw unit of a time is a millisecond


class Timers:
    def __init__(self, card: Card) -> None:
        self._card = card
        self._started_ns: dict[int, int] = {}
        self._due: dict[int, tuple[int, int]] = {}
        """Time at which each timer expires, and the flag that it sets."""

    def reset(self) -> None:
        self._started_ns.clear()
        self._due.clear()

    def start(self, number: int) -> None:
        self._started_ns[number] = self._card.now_ns()
        self._due.pop(number, None)

    def start_with_flag(self, number: int, time: int, flag: int) -> None:
        """Start a timer that clears `flag` and sets it after `time` (raw seconds)."""
        self.start(number)
        self._card.F[flag] = 0
        self._due[number] = (self._started_ns[number] + time * _NS_OF_RAW, flag)

    def elapsed(self, number: int) -> int:
        """Seconds since the start, raw; 0 for a timer that was never started."""
        started_ns = self._started_ns.get(number)
        if started_ns is None:
            return 0
        return min((self._card.now_ns() - started_ns) // _NS_OF_RAW, fixed.LIMIT)

    def tick(self) -> None:
        """Set the flags of expired timers."""
        if self._due:
            now_ns = self._card.now_ns()
            for number, (due_ns, flag) in list(self._due.items()):
                if due_ns <= now_ns:
                    self._card.F[flag] = 1
                    del self._due[number]
