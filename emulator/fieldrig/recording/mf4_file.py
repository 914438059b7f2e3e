"""Recorded rows as MF4 (ASAM MDF 4), by asammdf: each signal is a channel with its own instants, unit and type.

Truth values are 0 and 1, texts are texts of up to 128 bytes.  Times are seconds since the beginning of the recording,
whose instant is in the comment of the file.  The file is written at the end; until then rows are in a file of asammdf.
"""

import shutil
from collections.abc import Mapping
from math import isnan, nan
from tempfile import NamedTemporaryFile
from typing import Any, BinaryIO, Final

from fieldrig.clock import S
from fieldrig.recording.files import RowsFile
from fieldrig.recording.signals import Sort
from fieldrig.traces.mf4_library import asammdf

ROWS: Final = 10_000
"""Samples of a signal that wait in memory, at most."""
LONGEST_TEXT: Final = 128
TYPES: Final = {Sort.NUMBER: "<f8", Sort.TRUTH: "u1", Sort.TEXT: f"S{LONGEST_TEXT}"}


class Mf4File(RowsFile):
    """A channel group for each signal, as signals have values at different instants."""

    def _open(self, file: BinaryIO) -> None:
        import numpy

        library = asammdf()
        self._file, self._numpy = file, numpy
        self._mdf = library.MDF(version="4.10")
        self._mdf.header.comment = f"fieldrig: instant 0 is {self._begin_ns} ns on the clock of the rig"
        self._times: list[list[float]] = [[] for _ in self._columns]
        self._samples: list[list[Any]] = [[] for _ in self._columns]
        for column in self._columns:
            samples = numpy.array([], dtype=TYPES[column.kind])
            options = {"encoding": "utf-8"} if column.kind is Sort.TEXT else {}
            times = numpy.array([], dtype="<f8")
            self._mdf.append(library.Signal(samples, times, unit=column.unit, name=column.name, **options))

    def _write(self, time_ns: int, values: Mapping[int, float]) -> None:
        for place, number in values.items():
            sample = self._sample(place, number)
            if sample is None:
                continue
            self._times[place].append((time_ns - self._begin_ns) / S)
            self._samples[place].append(sample)
            if len(self._times[place]) >= ROWS:
                self._extend(place)

    def _sample(self, place: int, number: float) -> Any:
        """Return the value as its channel has it; None for a truth value that there is not."""
        value = self._shown(place, number)
        kind = self._columns[place].kind
        if kind is Sort.NUMBER:
            return nan if value is None else value
        if kind is Sort.TEXT:
            return str(value or "").encode()[:LONGEST_TEXT]
        return None if value is None or isnan(number) else int(bool(value))

    def _extend(self, place: int) -> None:
        if not self._times[place]:
            return
        samples = self._numpy.array(self._samples[place], dtype=TYPES[self._columns[place].kind])
        self._mdf.extend(place, [(self._numpy.array(self._times[place]), None), (samples, None)])
        self._times[place].clear()
        self._samples[place].clear()

    def _close(self) -> None:
        for place in range(len(self._columns)):
            self._extend(place)
        with NamedTemporaryFile("w+b", suffix=".mf4") as whole:  # asammdf reads it again
            self._mdf.save(whole, compression=1)
            self._mdf.close()
            whole.seek(0)
            shutil.copyfileobj(whole, self._file)
