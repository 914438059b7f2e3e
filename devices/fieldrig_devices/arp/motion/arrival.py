"""When an axis has arrived: its error has stayed inside the window for the dwell.

Source: manual 3.2, @ParX[15], [16], and 4.6 (F260); digest chapter 12.  Once arrived it stays so until it moves again.
"""


class Arrival:
    """`is_awaited` tells whether there is anything to look at."""

    __slots__ = ("_inside_ns", "is_awaited")

    def __init__(self) -> None:
        self.expect()

    def expect(self) -> None:
        """From now on."""
        self.is_awaited = True
        self._inside_ns: int | None = None

    def forget(self) -> None:
        self.is_awaited = False

    def has_come(self, now_ns: int, is_inside: bool, dwell_ns: int) -> bool:
        """Once a control loop while it is awaited."""
        if not is_inside:
            self._inside_ns = None
            return False
        if self._inside_ns is None:
            self._inside_ns = now_ns
        self.is_awaited = now_ns - self._inside_ns < dwell_ns
        return not self.is_awaited
