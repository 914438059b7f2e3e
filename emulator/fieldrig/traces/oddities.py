"""The oddities of a log that can be read all the same: a cut last line, a wrong date, a jump back in time.

A reader tells an oddity wherever it meets it.  Each kind is kept once, with its first place and the number of times, so
that a log of any length takes the same memory.
"""

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

from fieldrig.clock import MS, S
from fieldrig.points.values import counted
from fieldrig.text.digits import with_fewer_digits
from fieldrig.traces.trace import TraceEntry, is_time_of_day

MOST_KINDS: Final = 100
DAY_NS: Final = 24 * 3600 * S
LATEST_NS: Final = (1 << 63) - 1
"""The last instant of a trace, in the year 2262: one has 64 bits, as in JSON lines and in the formats of others."""
MOST_BUSES: Final = 10_000
"""Buses whose last instant is remembered."""


@dataclass(slots=True)
class Oddity:
    """One kind of oddity, as it was met first."""

    what: str
    place: str
    detail: str = ""
    count: int = 1

    def __str__(self) -> str:
        more = f" ({counted(self.count, 'time')} in all)" if self.count > 1 else ""
        return f"{self.place}: {self.what}{self.detail}{more}" if self.place else f"{self.what}{self.detail}{more}"


class Oddities:
    """The oddities of one log.  A reader keeps `number` at what it reads, and `unit` says what that counts."""

    def __init__(self) -> None:
        self.unit = "message"
        """The thing that the reader counts: line, packet, object, row."""
        self.number = 0
        self.jumped_to: int | None = None
        """The byte at which reading went on after the first lines, if a part of the log was left out."""
        self._kinds: dict[str, Oddity] = {}

    @property
    def place(self) -> str:
        """The place at which the reader is, such as `line 17`."""
        after = "" if self.jumped_to is None else f" of the part from byte {self.jumped_to}"
        return f"{self.unit} {self.number}{after}" if self.number else ""

    def report(self, what: str, detail: str = "") -> None:
        """Note an oddity at the present place.  `what` is its kind, and `detail` follows it for the first of the kind.

        Kinds are texts of the program and no parts of a file, so there are few of them.
        """
        known = self._kinds.get(what)
        if known is not None:
            known.count += 1
        elif len(self._kinds) < MOST_KINDS:
            self._kinds[what] = Oddity(what, self.place, detail)

    def __iter__(self) -> Iterator[Oddity]:
        return iter(self._kinds.values())

    def __len__(self) -> int:
        return len(self._kinds)


def with_jumps_reported(entries: Iterable[TraceEntry], odd: Oddities) -> Iterator[TraceEntry]:
    """Yield the entries, and tell where the time of a bus jumps back, or by more than a day, or is in the future.

    Buses that are recorded side by side may be out of order to each other, which is not odd.
    """
    last_ns: dict[str, int] = {}
    bus, before_ns = "", 0
    soon_ns = time.time_ns() + DAY_NS
    for entry in entries:
        now_ns = entry.time_ns
        if not -LATEST_NS <= now_ns <= soon_ns:
            entry = _bounded(entry, odd)
            now_ns = entry.time_ns
        if entry.bus != bus:  # most messages are of the same bus as the one before
            if len(last_ns) < MOST_BUSES:
                last_ns[bus] = before_ns
            bus = entry.bus
            before_ns = last_ns.get(bus, now_ns)
        if not before_ns <= now_ns <= before_ns + DAY_NS and (now_ns < before_ns or odd.jumped_to is None):
            _report_jump(now_ns - before_ns, odd)
        before_ns = now_ns
        yield entry


def _bounded(entry: TraceEntry, odd: Oddities) -> TraceEntry:
    if abs(entry.time_ns) <= LATEST_NS:
        odd.report("the time is in the future", f", {_date(entry.time_ns)}")
        return entry
    odd.report("times beyond the year 2262 become the last one of a trace", f", {_date(entry.time_ns)}")
    return entry._replace(time_ns=max(min(entry.time_ns, LATEST_NS), -LATEST_NS))


def _report_jump(by_ns: int, odd: Oddities) -> None:
    how = with_fewer_digits(f"{abs(by_ns) / S:.{6 if abs(by_ns) >= MS else 9}f}".rstrip("0").rstrip("."))
    if by_ns < 0:
        odd.report("the time jumps back", f" by {how} s")
    else:
        odd.report("the time jumps forward by more than a day", f", {how} s")


def _date(time_ns: int) -> str:
    if not is_time_of_day(time_ns):
        return f"{time_ns / S} s"
    try:
        return time.strftime("%Y-%m-%d", time.localtime(time_ns // S))
    except (ValueError, OverflowError, OSError):
        return "beyond every calendar"
