"""The eight-digit display: what it shows at an instant (PAMS-044 to PAMS-048).

While nothing is wrong it scrolls the name and version of the application.  The manual gives no speed, no time for
messages, and no order among conditions.  Here a fatal error comes before errors, and errors before warnings.  The first
of several fatal errors is shown, as it is in the fatal error panel, and those of table 12-7 come before others.  The
latest of several errors or warnings is shown, and the earlier ones after its end.
"""

from typing import Final

from fieldrig.clock import MS, S
from fieldrig_devices.pam.panel.codes import Code, Kind
from fieldrig_devices.pam.panel.info import is_in_the_table_of_the_ring

DIGITS: Final = 8
ENDED_NS: Final = 2 * S
"""Time for which a warning is shown after its end (manual line 8659)."""
MESSAGE_NS: Final = 2 * S
"""Time for which a message is shown; the manual gives none."""
SCROLL_NS: Final = 300 * MS
"""Time after which the name has moved by a digit."""
MONITOR_NS: Final = 500 * MS
"""Period at which a monitored value is sampled again ("periodically", manual line 8525)."""
_ORDER: Final = (Kind.FATAL, Kind.ERROR, Kind.WARNING)


class Display:
    """Remembers the conditions of a PAM; `text` and `blinks` say what is seen."""

    def __init__(self) -> None:
        self.name = ""
        """Name and version of the application, which scroll."""
        self._since_ns = 0
        self._pending: list[Code] = []
        """Conditions without an end, oldest first."""
        self._brief: Code | None = None
        """A message, or a warning that has ended."""
        self._brief_until_ns = 0
        self._monitored: tuple[int, float] | None = None
        """The instant and value of the last assignment."""
        self._held = 0.0
        """The value that is shown until the period of that instant ends."""

    def restart(self, name: str, now_ns: int) -> None:
        """Show nothing but this name, at power-on."""
        self.name, self._since_ns = name, now_ns
        self._pending.clear()
        self._brief = self._monitored = None

    def show(self, code: Code, now_ns: int) -> bool:
        """Take a message over.  Return True if it has ended a condition that was pending."""
        ended = code.ended
        if ended is not None:
            return self._end(ended, now_ns)
        if code.kind is Kind.MESSAGE:
            self._show_briefly(code, now_ns, MESSAGE_NS)
            return False
        self._brief = None  # an older message does not hide a condition
        if code not in self._pending:
            self._pending.append(code)
        return False

    def _end(self, ended: Code, now_ns: int) -> bool:
        if ended not in self._pending:
            return False
        if ended.kind is Kind.WARNING and ended == self._condition():
            self._show_briefly(ended, now_ns, ENDED_NS)
        self._pending.remove(ended)
        return True

    def monitor(self, value: float, now_ns: int) -> None:
        """Show a value instead of the name; it is sampled once in a period."""
        last = self._monitored
        self._monitored = now_ns, value
        self._held = value if last is None else self._sampled(last, now_ns)

    def text(self, now_ns: int) -> str:
        """Return the eight characters that are seen at this instant, whether or not they blink."""
        condition = self._condition()
        if condition is not None and condition.kind is not Kind.WARNING:
            return str(condition)
        if self._brief is not None and now_ns < self._brief_until_ns:
            return str(self._brief)
        if condition is not None:
            return str(condition)
        if self._monitored is not None:
            return floating(self._sampled(self._monitored, now_ns))
        return self._scrolled(now_ns)

    def blinks(self) -> bool:
        """True if the display shows an error (manual line 8737)."""
        condition = self._condition()
        return condition is not None and condition.kind in (Kind.ERROR, Kind.FATAL)

    def _show_briefly(self, code: Code, now_ns: int, duration_ns: int) -> None:
        self._brief, self._brief_until_ns = code, now_ns + duration_ns

    def _condition(self) -> Code | None:
        fatal = [code for code in self._pending if code.is_fatal]
        if fatal:
            return min(fatal, key=lambda code: not is_in_the_table_of_the_ring(code))
        return min(reversed(self._pending), key=lambda code: _ORDER.index(code.kind), default=None)

    def _scrolled(self, now_ns: int) -> str:
        if not self.name:
            return " " * DIGITS
        band = " " * DIGITS + self.name
        start = (now_ns - self._since_ns) // SCROLL_NS % len(band)
        return (band + band)[start : start + DIGITS]

    def _sampled(self, last: tuple[int, float], now_ns: int) -> float:
        """Return the value shown in the period of `now_ns`: the last one of an earlier period, or else the held one."""
        set_ns, value = last
        return value if now_ns // MONITOR_NS > set_ns // MONITOR_NS else self._held


def floating(value: float) -> str:
    """Return a value in floating-point format, in at most eight characters where its exponent allows."""
    for precision in range(6, 0, -1):
        text = f"{value:.{precision}g}"
        if len(text) <= DIGITS:
            return text.rjust(DIGITS)
    return f"{value:.0e}".rjust(DIGITS)
