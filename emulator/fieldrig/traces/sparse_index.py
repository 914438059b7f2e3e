"""A jump to a time in a long log of text, without reading what is before it.

The log is looked at in a thousand places, which takes some milliseconds, whatever its length.  Where their times are in
order, a part of the log is read from the place before its beginning, and one more place earlier, as buses that are
recorded side by side are out of order by a little.  A log whose places are not in order, because a clock was set, is
read from its beginning.
"""

from bisect import bisect_left
from collections.abc import Callable
from itertools import pairwise
from typing import BinaryIO, Final, cast

from fieldrig.traces.oddities import Oddities
from fieldrig.traces.read_again import ReadAgain
from fieldrig.traces.window import origin_ns

PLACES: Final = 1024
LINE: Final = 1 << 12
"""Bytes that are read at a place: enough for the rest of a line and a whole one."""
SMALLEST: Final = 1 << 22
"""Bytes of a log that is read from its beginning, which takes no longer."""

Clock = Callable[[str], int | None]
"""Returns the instant of a line, without the beginning of the log; None for a line that has none."""


def jumped(file: BinaryIO, head: bytes, clock: Clock, offset_ns: int, odd: Oddities) -> BinaryIO:
    """Return the file from shortly before the first line that is `offset_ns` after the first one.

    `head` are its first bytes, with the beginning of the log and a line that has a time.  Times count from the first
    line, or from the start of a rig in virtual time.
    """
    size = file.seek(0, 2)
    found = _first_line(head, clock)
    if size < SMALLEST or found is None:
        file.seek(0)
        return file
    end, first_ns = found
    places = [(0, first_ns), *_places(file, end, size, clock)]
    file.seek(0)
    number = bisect_left([time_ns for _, time_ns in places], origin_ns(first_ns) + offset_ns) - 2
    if number <= 0 or any(later < earlier for (_, earlier), (_, later) in pairwise(places)):
        return file
    odd.jumped_to = file.seek(places[number][0])
    return cast(BinaryIO, ReadAgain(head[:end], file))


def _first_line(head: bytes, clock: Clock) -> tuple[int, int] | None:
    """Return the end of the first line with a time, and this time."""
    end = 0
    for line in head.splitlines(keepends=True):
        end += len(line)
        time_ns = clock(line.decode("latin-1")) if line.endswith(b"\n") else None
        if time_ns is not None:
            return end, time_ns
    return None


def _places(file: BinaryIO, begin: int, size: int, clock: Clock) -> list[tuple[int, int]]:
    """Return places at which lines begin, and the times of these lines."""
    found: list[tuple[int, int]] = []
    for number in range(PLACES):
        at = begin + (size - begin) * number // PLACES
        file.seek(at - 1)
        data = file.read(LINE)
        start = data.find(b"\n") + 1
        end = data.find(b"\n", start)
        time_ns = clock(data[start:end].decode("latin-1")) if 0 < start < end else None
        if time_ns is not None:
            found.append((at - 1 + start, time_ns))
    return found
