"""The eight-digit display: what it shows at an instant (PAMS-044 to PAMS-048).

While nothing is wrong it scrolls the name and version of the application.  The manual gives no speed, no time for
messages, and no order among conditions (`options`).  A fatal error comes before errors, and errors before warnings.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig.clock import S
from fieldrig_devices.pam.panel.codes import Code, Kind
from fieldrig_devices.pam.panel.options import PanelOptions

DIGITS: Final = 8
ENDED_NS: Final = 2 * S
"""Time for which a warning is shown after its end (manual line 8659)."""
_ORDER: Final = (Kind.FATAL, Kind.ERROR, Kind.WARNING)


class Display:
    """Remembers the conditions of a PAM; `text` and `blinks` say what is seen."""

    def __init__(self, options: PanelOptions | None = None) -> None:
        self._options = options or PanelOptions()
        self.name = ""
        """Name and version of the application, which scroll."""
        self._since_ns = 0
        self._pending: list[Code] = []
        """Conditions without an end, oldest first."""
        self._data: dict[Code, tuple[int, Sequence[int | float]]] = {}
        """The data fields of each code, and when they came."""
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
        self._data.clear()
        self._brief = self._monitored = None

    def show(self, code: Code, now_ns: int, data: Sequence[int | float] = ()) -> bool:
        """Take a message over with its data fields.  Return True if it has ended a condition that was pending."""
        ended = code.ended
        if ended is None:
            if self._options.data_ns:
                self._data[code] = now_ns, data
            if code.kind is Kind.MESSAGE:
                self._show_briefly(code, now_ns, self._options.message_ns)
            elif code not in self._pending:
                if self._options.several == "only_latest":
                    self._pending = [known for known in self._pending if known.is_fatal]
                self._pending.append(code)
            return False
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
            return self._seen(condition, now_ns)
        if self._brief is not None and now_ns < self._brief_until_ns:
            return self._seen(self._brief, now_ns)
        if condition is not None:
            return self._seen(condition, now_ns)
        if self._monitored is not None:
            return floating(self._sampled(self._monitored, now_ns))
        return self._scrolled(now_ns)

    def _seen(self, code: Code, now_ns: int) -> str:
        """Return a code, or one of its data fields if these take turns with it."""
        since_ns, data = self._data.get(code, (now_ns, ()))
        turn = (now_ns - since_ns) // max(self._options.data_ns, 1) % (1 + len(data))
        if turn == 0:
            return str(code)
        value = data[turn - 1]
        return f"{value & 0xFFFF_FFFF:08X}" if isinstance(value, int) else floating(value)

    def blinks(self) -> bool:
        """True if the display shows an error (manual line 8737)."""
        condition = self._condition()
        return condition is not None and condition.kind in (Kind.ERROR, Kind.FATAL)

    def _show_briefly(self, code: Code, now_ns: int, duration_ns: int) -> None:
        self._brief, self._brief_until_ns = code, now_ns + duration_ns

    def _condition(self) -> Code | None:
        pending = self._pending if self._options.several == "first" else reversed(self._pending)
        return min(pending, key=lambda code: _ORDER.index(code.kind), default=None)

    def _scrolled(self, now_ns: int) -> str:
        if not self.name:
            return " " * DIGITS
        band = " " * DIGITS + self.name
        start = (now_ns - self._since_ns) // self._options.scroll_ns % len(band)
        return (band + band)[start : start + DIGITS]

    def _sampled(self, last: tuple[int, float], now_ns: int) -> float:
        """Return the value shown in the period of `now_ns`: the last one of an earlier period, or else the held one."""
        set_ns, value = last
        period_ns = self._options.monitor_ns
        return value if now_ns // period_ns > set_ns // period_ns else self._held


def floating(value: float) -> str:
    """Return a value in floating-point format, in at most eight characters where its exponent allows."""
    for precision in range(6, 0, -1):
        text = f"{value:.{precision}g}"
        if len(text) <= DIGITS:
            return text.rjust(DIGITS)
    return f"{value:.0e}".rjust(DIGITS)
