"""Recorded rows as MF4 (ASAM MDF 4), by asammdf: each signal is a channel with its own instants, unit and type.

A signal of whole numbers, some of them beyond 2^53, has 64 bits, and is invalid where it had no value; other numbers
are floats.  Truth values are 0 and 1, texts are texts of up to 128 bytes.  Times are whole nanoseconds since the
beginning of the recording, whose instant is in the comment of the file.  The types are known at the end, so the rows
are in a file of ours until then.
"""

import shutil
import struct
from array import array
from collections.abc import Iterator, Mapping
from math import isnan, nan
from tempfile import NamedTemporaryFile, TemporaryFile
from typing import IO, Any, BinaryIO, Final

from fieldrig.recording.files import RowsFile
from fieldrig.recording.signals import Column, Sort
from fieldrig.traces.mf4_library import asammdf, count_nanoseconds

ROWS: Final = 10_000
"""Samples of a signal that wait in memory, at most."""
LONGEST_TEXT: Final = 128
TYPES: Final = {Sort.NUMBER: "<f8", Sort.TRUTH: "u1", Sort.TEXT: f"S{LONGEST_TEXT}"}
FIRST: Final = -(1 << 63)
LAST: Final = (1 << 64) - 1
"""The first and the last whole number that a channel of 64 bits can have."""
WHOLE: Final = struct.Struct("<H9s")
EXACT: Final = 1 << 53
"""Whole numbers up to this one are exact as floats."""


class Mf4File(RowsFile):
    """A channel group for each signal, as signals have values at different instants."""

    def _open(self, file: BinaryIO) -> None:
        asammdf()  # that it is missing is said before anything is recorded
        self._file, self._spool = file, TemporaryFile()  # noqa: SIM115  closed by _close
        self._samples = [_Samples(self._spool) for _ in self._columns]

    def _write(self, time_ns: int, values: Mapping[int, float]) -> None:
        for place, number in values.items():
            if self._columns[place].kind is not Sort.TRUTH or not isnan(number):
                self._samples[place].add(time_ns - self._begin_ns, number)

    def _close(self) -> None:
        library = asammdf()
        mdf = library.MDF(version="4.10")
        mdf.header.comment = f"fieldrig: instant 0 is {self._begin_ns} ns on the clock of the rig"
        for place, column in enumerate(self._columns):
            self._append(library, mdf, column, place)
        self._spool.close()
        with NamedTemporaryFile("w+b", suffix=".mf4") as whole:  # asammdf reads it again
            mdf.save(whole, compression=1)
            mdf.close()
            whole.seek(0)
            shutil.copyfileobj(whole, self._file)

    def _append(self, library: Any, mdf: Any, column: Column, place: int) -> None:
        import numpy

        samples = self._samples[place]
        whole = samples.whole_type if column.kind is Sort.NUMBER else ""
        kind = whole or TYPES[column.kind]
        options: dict[str, Any] = {"encoding": "utf-8"} if column.kind is Sort.TEXT else {}
        if whole:
            options["invalidation_bits"] = numpy.array([], dtype=bool)
        times = numpy.array([], dtype="<i8")
        mdf.append(library.Signal(numpy.array([], dtype=kind), times, unit=column.unit, name=column.name, **options))
        count_nanoseconds(mdf, place)
        for times_ns, numbers in samples.chunks():
            values = [0 if isnan(each) else int(each) for each in numbers] if whole else self._floats(place, numbers)
            invalid = numpy.array([isnan(each) for each in numbers]) if whole else None
            mdf.extend(
                place, [(numpy.frombuffer(times_ns, dtype="<i8"), None), (numpy.array(values, dtype=kind), invalid)]
            )

    def _floats(self, place: int, numbers: list[float]) -> list[Any]:
        """Return values as a channel has them that is none of whole numbers."""
        shown = (self._shown(place, number) for number in numbers)
        kind = self._columns[place].kind
        if kind is Sort.NUMBER:
            return [nan if value is None else value for value in shown]
        if kind is Sort.TEXT:
            return [str(value or "").encode()[:LONGEST_TEXT] for value in shown]
        return [int(bool(value)) for value in shown]


class _Samples:
    """The samples of a signal, in a file that all signals share; whole numbers beyond 2^53 are beside their floats."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._times, self._numbers = array("q"), array("d")
        self._beyond: dict[int, int] = {}
        """Whole numbers that a float would round, by their row."""
        self._parts: list[tuple[int, int, int]] = []
        """Place in the file, number of samples, and of such whole numbers."""
        self._are_whole, self._least, self._most = True, 0, 0

    def add(self, time_ns: int, number: float) -> None:
        if not isnan(number):
            if number < self._least or number > self._most:
                self._are_whole &= FIRST <= number <= LAST  # a wider one, and infinity, is a float
                if self._are_whole:
                    self._least, self._most = min(self._least, int(number)), max(self._most, int(number))
            if self._are_whole and number % 1:
                self._are_whole = False
            if self._are_whole and isinstance(number, int):
                self._beyond[len(self._numbers)] = number
        self._times.append(time_ns)
        self._numbers.append(number)
        if len(self._times) >= ROWS:
            self._flush()

    @property
    def whole_type(self) -> str:
        """The type of a channel of whole numbers beyond 2^53; empty if there is none that has all values."""
        if not self._are_whole or -EXACT <= self._least <= self._most <= EXACT:
            return ""
        if self._most < 1 << 63:
            return "<i8"
        return "<u8" if self._least >= 0 else ""

    def chunks(self) -> Iterator[tuple[bytes, list[float]]]:
        """Yield instants and values, some thousand at once."""
        self._flush()
        for at, count, exact in self._parts:
            self._file.seek(at)
            times_ns, numbers = self._file.read(8 * count), array("d", self._file.read(8 * count)).tolist()
            for _ in range(exact):
                row, number = WHOLE.unpack(self._file.read(WHOLE.size))
                numbers[row] = int.from_bytes(number, "little", signed=True)
            yield times_ns, numbers

    def _flush(self) -> None:
        if self._times:
            at = self._file.seek(0, 2)
            self._file.write(self._times.tobytes() + self._numbers.tobytes())
            for row, number in self._beyond.items():
                self._file.write(WHOLE.pack(row, number.to_bytes(9, "little", signed=True)))
            self._parts.append((at, len(self._times), len(self._beyond)))
        self._times, self._numbers, self._beyond = array("q"), array("d"), {}
