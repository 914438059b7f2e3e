"""Detection of the arrival of an axis: its error has stayed inside the window for the dwell time.

Source: manual 3.2, @ParX[15], [16], and 4.6 (F260); digest chapter 12.  Once an axis has arrived, it stays so until it
moves again.
"""


class Arrival:
    """Arrival of one axis.  `is_awaited` is False if there is nothing to check."""

    __slots__ = ("_inside_ns", "is_awaited")

    def __init__(self) -> None:
        self.expect()

    def expect(self) -> None:
        """Await an arrival from now on."""
        self.is_awaited = True
        self._inside_ns: int | None = None

    def forget(self) -> None:
        self.is_awaited = False

    def check(self, now_ns: int, is_inside: bool, dwell_ns: int) -> bool:
        """Check once per control loop while an arrival is awaited.  True when the axis arrives."""
        if not is_inside:
            self._inside_ns = None
            return False
        if self._inside_ns is None:
            self._inside_ns = now_ns
        self.is_awaited = now_ns - self._inside_ns < dwell_ns
        return not self.is_awaited
