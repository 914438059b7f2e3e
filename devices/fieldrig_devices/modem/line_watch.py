"""The watch over a telephone line: a modem answers after some rings, and hangs up when nothing is transferred."""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import Alarm, Clock, S
from fieldrig_devices.modem.profile import Profile

FORGOTTEN_NS: Final = 8 * S
"""The time without a ring after which S1 is 0."""
MOST_RINGS: Final = 255


class Ringing:
    """The rings in S1, and the ring after which S0 has the modem answer (ITU-T V.250, 6.3.8)."""

    def __init__(self, clock: Clock, profile: Callable[[], Profile]) -> None:
        self._clock, self._profile = clock, profile
        self.is_on = False
        """The ringing voltage is there."""
        self._timer = Alarm(self._clock)

    def begin(self) -> None:
        """Count a ring that begins."""
        registers = self._profile().registers
        registers[1] = min(registers[1] + 1, MOST_RINGS)
        self._timer.after(FORGOTTEN_NS, self.forget)

    def is_enough(self) -> bool:
        """Return whether the modem answers by itself after the rings so far."""
        registers = self._profile().registers
        return 0 < registers[0] <= registers[1]

    def forget(self) -> None:
        self._profile().registers[1] = 0


IDLE_UNIT_NS: Final = 10 * S
"""The unit of S30."""


class IdleWatch:
    """Hangs up when nothing was sent or received for the time of S30."""

    def __init__(self, clock: Clock, limit: Callable[[], int], on_idle: Callable[[], None]) -> None:
        """`limit` returns the value of S30; 0 is no limit."""
        self._clock, self._limit, self._on_idle = clock, limit, on_idle
        self.last_ns = 0
        """The instant of the last data."""
        self._timer = Alarm(self._clock)

    def start(self) -> None:
        self.last_ns = self._clock.now_ns()
        self._look()

    def stop(self) -> None:
        self._timer.stop()

    def _look(self) -> None:
        limit_ns = self._limit() * IDLE_UNIT_NS
        if not limit_ns:
            return
        due_ns = self.last_ns + limit_ns
        if due_ns <= self._clock.now_ns():
            self._on_idle()
        else:
            self._timer.at(due_ns, self._look)
