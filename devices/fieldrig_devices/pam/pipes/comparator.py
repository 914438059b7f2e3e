"""The comparator: it passes the flow on, and tells when it reaches a reference (PAML-460 to PAML-468)."""

from collections.abc import Callable

from fieldrig_devices.pam.pipes.block import Block


def _nothing() -> None:
    pass


class Comparator(Block):
    """A comparator; `ready` is true while the flow is at or above the reference.

    In the mode THROUGH_ZERO the flow has to pass the limit of its period first.  A wrap in either direction is such a
    passage, and afterwards the block compares as in the normal mode until the reference is written again (G-31).
    """

    def __init__(self, reference: float, *, is_through_zero: bool = False) -> None:
        super().__init__()
        self.reference = reference
        self._is_through_zero = is_through_zero
        self._waits_for_zero = is_through_zero
        self._last: float | None = None
        self._is_reached = False
        self.routine: Callable[[], None] = _nothing
        """Started when `ready` becomes true."""
        self.reverse_routine: Callable[[], None] = _nothing
        """Started when `ready` becomes false."""

    @property
    def ready(self) -> bool:
        return self._is_reached

    @property
    def is_at_rest(self) -> bool:
        return True

    def set_reference(self, reference: float, *, is_through_zero: bool) -> None:
        """Write REFERENCE or THROUGH_ZERO_REFERENCE, which also selects the mode (PAML-463)."""
        self.reference = reference
        self._is_through_zero = self._waits_for_zero = is_through_zero
        if self._last is not None:
            self._compare(self._last, has_wrapped=False)

    def start(self, period_s: float) -> None:
        super().start(period_s)
        self._waits_for_zero = self._is_through_zero
        self._last, self._is_reached = None, False

    def transform(self, value: float) -> float:
        """The first value of a pipe sets the state without starting a routine (G-32)."""
        last, self._last = self._last, value
        if last is None:
            self._is_reached = not self._waits_for_zero and value >= self.reference
            return value
        self._compare(value, has_wrapped=self._has_wrapped(last, value))
        return value

    def _has_wrapped(self, last: float, value: float) -> bool:
        return self.period is not None and abs(value - last) > self.period / 2

    def _compare(self, value: float, *, has_wrapped: bool) -> None:
        self._waits_for_zero = self._waits_for_zero and not has_wrapped
        was_reached, self._is_reached = self._is_reached, not self._waits_for_zero and value >= self.reference
        if self._is_reached and not was_reached:
            self.routine()
        elif was_reached and not self._is_reached:
            self.reverse_routine()
