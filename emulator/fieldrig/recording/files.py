"""Recorded rows in files while they come: CSV, and value change dumps (IEEE 1364-2005, clause 18).

Rows of several processes and devices are put in the order of time.  For this they wait until everything before an
instant is there (`advance`).
"""

import csv
import io
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from heapq import heappop, heappush
from math import isnan, nan
from typing import IO, Any, BinaryIO, cast

from vcd.common import VarType
from vcd.writer import VCDWriter

from fieldrig.clock import S
from fieldrig.recording.reader import Rows
from fieldrig.recording.signals import Column, Sort
from fieldrig.traces.vcd_text import Ascii, Exact, ExactWhole, legal_paths, quoted

Value = bool | float | str | None


class RowsFile(ABC):
    """A file of recorded values, written in the order of time."""

    def __init__(self, file: BinaryIO, columns: Sequence[Column], begin_ns: int) -> None:
        """`begin_ns` is the instant at which the recording began."""
        self._columns, self._begin_ns = columns, begin_ns
        self._waiting: list[tuple[int, int, tuple[int, ...], tuple[float, ...]]] = []
        """Instant, number in the order of arrival, columns and their values."""
        self._before: dict[int, float] = {}
        """The values that hold at the beginning, as processes begin one after the other."""
        self._taken = 0
        self._last_ns = begin_ns
        self.lines = 0
        """Instants that were written."""
        self._open(file)

    def take(self, rows: Rows) -> None:
        for row, (time_ns, *values) in enumerate(zip(rows.times_ns, *rows.values, strict=False)):
            if rows.whole:
                values = [rows.whole.get((place, row), value) for place, value in enumerate(values)]
            if time_ns < self._begin_ns:
                early = zip(rows.columns, values, strict=True)
                self._before |= {column: value for column, value in early if self._columns[column].is_held}
                continue
            self._taken += 1
            heappush(self._waiting, (max(time_ns, self._last_ns), self._taken, rows.columns, tuple(values)))

    def advance(self, until_ns: int) -> None:
        """Write what came up to this instant."""
        if self._before and until_ns >= self._begin_ns:
            heappush(self._waiting, (self._begin_ns, 0, tuple(self._before), tuple(self._before.values())))
            self._before.clear()
        for time_ns, values in self._instants(until_ns):
            self._last_ns = time_ns
            self.lines += 1
            self._write(time_ns, values)

    def close(self, until_ns: int = 1 << 62) -> None:
        """Write everything up to this instant, and end the file."""
        self.advance(until_ns)
        self._close()

    def _instants(self, until_ns: int) -> Iterator[tuple[int, Mapping[int, float]]]:
        """Yield the values of each instant by their columns; a column with two values at one instant comes again."""
        waiting, present, now_ns = self._waiting, dict[int, float](), 0
        while waiting and waiting[0][0] <= until_ns:
            time_ns, _, columns, values = heappop(waiting)
            if present and (time_ns != now_ns or not present.keys().isdisjoint(columns)):
                yield now_ns, present
                present = {}
            now_ns = time_ns
            present.update(zip(columns, values, strict=True))
        if present:
            yield now_ns, present

    def _shown(self, column: int, value: float) -> Value:
        """Return a value as people read it; None for none."""
        of_it = self._columns[column]
        if isnan(value):
            return None
        if of_it.kind is Sort.TEXT:
            place = int(value)
            return of_it.states[place] if 0 <= place < len(of_it.states) else None
        return bool(value) if of_it.kind is Sort.TRUTH else value

    @abstractmethod
    def _open(self, file: BinaryIO) -> None: ...

    @abstractmethod
    def _write(self, time_ns: int, values: Mapping[int, float]) -> None: ...

    @abstractmethod
    def _close(self) -> None: ...


class CsvFile(RowsFile):
    """A line for each instant: seconds since the beginning of the recording, then a field for each signal (RFC 4180).

    A field is empty where the signal had no value at this instant.  Truth values are 0 and 1.
    """

    def _open(self, file: BinaryIO) -> None:
        self._text = io.TextIOWrapper(file, encoding="utf-8", newline="", write_through=True)
        self._csv = csv.writer(self._text)
        units = (f"{column.name} [{column.unit}]" if column.unit else column.name for column in self._columns)
        self._csv.writerow(["time_s", *units])

    def _write(self, time_ns: int, values: Mapping[int, float]) -> None:
        whole, rest = divmod(time_ns - self._begin_ns, S)
        fields = (_field(self._shown(place, values.get(place, nan))) for place in range(len(self._columns)))
        self._csv.writerow([f"{whole}.{rest:09}", *fields])

    def _close(self) -> None:
        self._text.flush()
        self._text.detach()  # the file is closed by its owner


def _field(value: Value) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return value
    return str(int(value)) if isinstance(value, bool) else repr(value).removesuffix(".0")


class VcdFile(RowsFile):
    """Each signal a variable: truth values a wire of one bit, numbers a real, texts a string as GTKWave has them."""

    def _open(self, file: BinaryIO) -> None:
        names = [tuple(column.name.split("/", 1)) for column in self._columns]
        paths = legal_paths([(part, key.replace("/", ".")) for part, key in names])
        lines = [f"fieldrig: instant 0 is {self._begin_ns} ns on the clock of the rig"]
        for column, path in zip(self._columns, paths, strict=True):
            unit = f" in {quoted(column.unit)}" if column.unit else ""
            lines.append(f"{'.'.join(path)} is {quoted(column.name)}{unit}")
        output = cast(IO[str], Ascii(file))
        self._vcd = VCDWriter(output, "1 ns", date="", comment="\n".join(lines), version="fieldrig")
        self._variables: list[Any] = []
        for column, path in zip(self._columns, paths, strict=True):
            scope, name = path[:-1], path[-1]
            if column.kind is Sort.TRUTH:
                self._variables.append(self._vcd.register_var(scope, name, VarType.wire, size=1))
            elif column.kind is Sort.TEXT:
                self._variables.append(self._vcd.register_var(scope, name, VarType.string))
            else:
                self._variables.append(self._vcd.register_var(scope, name, VarType.real, init=nan))
        self._vcd.flush()

    def _write(self, time_ns: int, values: Mapping[int, float]) -> None:
        for column, number in values.items():
            value = self._shown(column, number)
            kind = self._columns[column].kind
            if isinstance(value, int) and kind is Sort.NUMBER:
                changed: Any = ExactWhole(value)
            elif kind is Sort.NUMBER:
                changed = Exact(nan if value is None else value)
            elif kind is Sort.TEXT:
                changed = "" if value is None else ascii(value)[1:-1]
            else:
                changed = "x" if value is None else int(bool(value))
            self._vcd.change(self._variables[column], time_ns - self._begin_ns, changed)

    def _close(self) -> None:
        self._vcd.close(self._last_ns - self._begin_ns)
