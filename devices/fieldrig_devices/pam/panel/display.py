"""The eight-digit display: what it shows at an instant (PAMS-044 to PAMS-048).

While nothing is wrong it scrolls the name and version of the application.  The manual gives no speed, no time for
messages, and no order among conditions.  Here a message is shown for 2 s, like an ended warning.  A fatal error comes
before errors, errors come before warnings, and the latest of a kind comes before the others.
"""

from typing import Final

from fieldrig.clock import MS, S
from fieldrig_devices.pam.panel.codes import Code, Kind

DIGITS: Final = 8
SHOWN_NS: Final = 2 * S
"""Time for which a message is shown, and a warning after its end (manual line 8659)."""
SCROLL_NS: Final = 300 * MS
"""Time after which the text has moved by a digit."""
MONITOR_NS: Final = 500 * MS
"""Period at which a monitored value is sampled again."""
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
        if ended is None:
            if code.kind is Kind.MESSAGE:
                self._show_briefly(code, now_ns)
            elif code not in self._pending:
                self._pending.append(code)
            return False
        if ended not in self._pending:
            return False
        if ended.kind is Kind.WARNING and ended == self._condition():
            self._show_briefly(ended, now_ns)
        self._pending.remove(ended)
        return True

    def monitor(self, value: float, now_ns: int) -> None:
        """Show a value instead of the name; it is sampled once per `MONITOR_NS`."""
        last = self._monitored
        self._monitored = now_ns, value
        self._held = value if last is None else _sampled(last, self._held, now_ns)

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
            return floating(_sampled(self._monitored, self._held, now_ns))
        return self._scrolled(now_ns)

    def blinks(self) -> bool:
        """True if the display shows an error (manual line 8737)."""
        condition = self._condition()
        return condition is not None and condition.kind in (Kind.ERROR, Kind.FATAL)

    def _show_briefly(self, code: Code, now_ns: int) -> None:
        self._brief, self._brief_until_ns = code, now_ns + SHOWN_NS

    def _condition(self) -> Code | None:
        for kind in _ORDER:
            for code in reversed(self._pending):
                if code.kind is kind:
                    return code
        return None

    def _scrolled(self, now_ns: int) -> str:
        if not self.name:
            return " " * DIGITS
        band = " " * DIGITS + self.name
        start = (now_ns - self._since_ns) // SCROLL_NS % len(band)
        return (band + band)[start : start + DIGITS]


def _sampled(last: tuple[int, float], held: float, now_ns: int) -> float:
    """Return the value shown in the period of `now_ns`: the last assignment of an earlier period, or else `held`."""
    set_ns, value = last
    return value if now_ns // MONITOR_NS > set_ns // MONITOR_NS else held


def floating(value: float) -> str:
    """Return a value in floating-point format, in at most eight characters where its exponent allows."""
    for precision in range(6, 0, -1):
        text = f"{value:.{precision}g}"
        if len(text) <= DIGITS:
            return text.rjust(DIGITS)
    return f"{value:.0e}".rjust(DIGITS)
