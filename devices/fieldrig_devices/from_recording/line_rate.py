"""The baud rate and format of a serial line, which captures of Modbus seldom say.

A format that one end has set is in the recording itself.  Characters with stamps of their own follow each other at the
pace of the line.  Whole frames show it where answers of several sizes come: each further character adds its duration
to the fastest answer.  Where nothing shows the rate, the fastest answer still says which rates are too slow.

Source: Modbus over serial line V1.02, 2.5.1: a character of RTU has 11 bits, or 10 without parity.
"""

from collections import Counter
from collections.abc import Iterator
from typing import Final, NamedTuple

from fieldrig.clock import MS, US, S
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.framing import FAST_BAUD
from fieldrig_bus.serial.codec import DATA, FORMAT, decode
from fieldrig_bus.serial.message import Format

RATES: Final = (1_200, 2_400, 4_800, 9_600, 14_400, 19_200, 28_800, 38_400, 57_600, 76_800, 115_200, 230_400)
"""Usual baud rates, at which durations of 10 and of 11 bits are apart."""
BITS: Final = (10, 11)
NEAR: Final = 0.02
"""The share by which a duration may differ from that of a rate."""
STAMP_NS: Final = US
FEWEST: Final = 20
DATA_BITS: Final = (7, 8)
BAUDS: Final = range(300, 10_000_001)
"""Formats that a line of Modbus can have here."""
MOST_SIZES: Final = 256
FEWEST_SIZES: Final = 3
LEAST_RANGE: Final = 16
"""Characters between the shortest and the longest answer, below which a slope says little."""
AROUND_PDU: Final = 3
"""Unit and CRC of a frame of RTU."""
AROUND_ASCII: Final = 7
"""Colon, unit, LRC, CR and LF of a frame of ASCII."""
SILENCE: Final = 3.5
"""The silence in front of a frame of RTU, in characters."""


class Rate(NamedTuple):
    """The format of a line, and how it is known or what is open."""

    form: Format
    words: str


class LineRate:
    """Collects what shows the rate of one line."""

    def __init__(self) -> None:
        self._format: Format | None = None
        self._last: tuple[str, int] | None = None
        """Side and instant of the last single character."""
        self._votes: Counter[tuple[int, int]] = Counter()
        self._distances = self._uneven = 0
        self._fastest: dict[tuple[int, int], int] = {}
        """The shortest time between a request and its answer, by the sizes of their PDUs."""

    def take(self, entry: TraceEntry) -> None:
        """Take an entry of a serial line."""
        kind = entry.data[0] if entry.data else None
        if kind == FORMAT:
            self._take_format(entry.data)
        elif kind == DATA:
            is_single = len(entry.data) == 2
            if is_single and self._last is not None and self._last[0] == entry.sender:
                self._take_distance(entry.time_ns - self._last[1])
            self._last = (entry.sender, entry.time_ns) if is_single else None

    def take_exchange(self, request_size: int, response_size: int, time_ns: int) -> None:
        """Take the time between a request and its answer; the sizes are those of the PDUs."""
        sizes = request_size, response_size
        if time_ns > 0 and (sizes in self._fastest or len(self._fastest) < MOST_SIZES):
            self._fastest[sizes] = min(time_ns, self._fastest.get(sizes, time_ns))

    def rate(self, *, is_ascii: bool) -> Rate:
        """Return the rate that the recording shows, else one at which its fastest answer was possible."""
        if self._format is not None:
            return Rate(self._format, "as the recording says")
        if (pace := self._by_characters()) is not None:
            return _rate(*pace, is_ascii, "from the times of its characters")
        if (pace := self._by_sizes(2 if is_ascii else 1)) is not None:
            return _rate(*pace, is_ascii, "from the times of its answers")
        needed = max((_needed(sizes, time_ns, is_ascii) for sizes, time_ns in self._fastest.items()), default=0)
        least = next((rate for rate in RATES if rate >= max(needed, FAST_BAUD)), RATES[-1])
        fast = f" (its fastest answer needs {least} bit/s or more)" if least > FAST_BAUD else ""
        words = f"the recording does not say it{fast}: set baud, parity and stop_bits of your line"
        return Rate(_form(least, max(BITS), is_ascii), words)

    def _take_format(self, data: bytes) -> None:
        try:
            form = decode(data)
        except ValueError:
            return
        if isinstance(form, Format) and form.data_bits in DATA_BITS and form.baud in BAUDS:
            self._format = form

    def _take_distance(self, distance_ns: int) -> None:
        if not 0 < distance_ns < 2 * max(BITS) * S // RATES[0]:
            return
        self._distances += 1
        self._uneven += bool(distance_ns % MS)
        self._votes.update(_paces(distance_ns, STAMP_NS))

    def _by_characters(self) -> tuple[int, int] | None:
        """Return rate and bits, unless the stamps are of milliseconds or follow no pace."""
        if not self._votes or 2 * self._uneven < self._distances:
            return None
        pace, votes = self._votes.most_common(1)[0]
        return pace if votes >= max(FEWEST, self._distances / 2) else None

    def _by_sizes(self, characters: int) -> tuple[int, int] | None:
        """Return rate and bits of the slope of the fastest answers to requests of one size.

        A byte has this number of `characters`.
        """
        groups: dict[int, list[tuple[int, int]]] = {}
        for (request_size, response_size), time_ns in self._fastest.items():
            groups.setdefault(request_size, []).append((response_size, time_ns))
        points = max(groups.values(), key=len, default=[])
        sizes = [size for size, _ in points]
        if len(points) < FEWEST_SIZES or max(sizes) - min(sizes) < LEAST_RANGE:
            return None
        slope, base = _line_through(points)
        if any(abs(base + slope * size - time_ns) > slope / 2 + STAMP_NS for size, time_ns in points):
            return None
        return next(_paces(slope / characters, 0), None)


def _needed(sizes: tuple[int, int], time_ns: int, is_ascii: bool) -> float:
    """Return the rate below which an answer after this time is impossible, whether stamps are of begins or ends."""
    characters = 2 * min(sizes) + AROUND_ASCII if is_ascii else min(sizes) + AROUND_PDU + SILENCE
    return characters * min(BITS) * S / time_ns


def _paces(duration_ns: float, stamp_ns: int) -> Iterator[tuple[int, int]]:
    """Yield each rate, with the bits of its characters, that this duration of a character may be."""
    for rate in RATES:
        for bits in BITS:
            exact_ns = bits * S / rate
            if abs(duration_ns - exact_ns) <= exact_ns * NEAR + stamp_ns:
                yield rate, bits


def _line_through(points: list[tuple[int, int]]) -> tuple[float, float]:
    """Return slope and base of the line with the least squares."""
    mean_size = sum(size for size, _ in points) / len(points)
    mean_ns = sum(time_ns for _, time_ns in points) / len(points)
    square = sum((size - mean_size) ** 2 for size, _ in points)
    slope = sum((size - mean_size) * (time_ns - mean_ns) for size, time_ns in points) / square
    return slope, mean_ns - slope * mean_size


def _rate(baud: int, bits: int, is_ascii: bool, words: str) -> Rate:
    form = _form(baud, bits, is_ascii)
    taken = f"{form.data_bits}{form.parity}{form.stop_bits}"
    return Rate(form, f"{words}: {bits} bits each, as in {taken}")


def _form(baud: int, bits: int, is_ascii: bool) -> Format:
    """Return the usual format with this number of bits (V1.02, 2.5.1 and 2.5.2)."""
    if is_ascii and bits == min(BITS):
        return Format(baud, 7, "E", 1)
    return Format(baud, 8, "N" if bits == min(BITS) else "E", 1)
