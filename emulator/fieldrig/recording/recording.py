"""Recordings for tests: the instants and values of signals as arrays, and as files.

For example, of a rig in virtual time:

    recording = rig.record(["drive/position", "wires/lamp.on"])
    rig.run_for(2 * S)
    assert max(recording.values["drive/position"]) < 1000
    recording.write_csv("drive.csv")
"""

from abc import ABC, abstractmethod
from array import array
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Self

from fieldrig.recording.files import CsvFile, RowsFile, VcdFile
from fieldrig.recording.live_reader import LiveReader
from fieldrig.recording.mf4_file import Mf4File
from fieldrig.recording.reader import Assembler, Rows
from fieldrig.recording.record_set import RecordSet
from fieldrig.recording.signals import Column, Rhythm, Source


class Recording(ABC):
    """Signals of a rig from `Rig.record` or `LiveRig.record` until `end`, or until the rig is closed."""

    def __init__(self, columns: Sequence[Column], begin_ns: int) -> None:
        self.columns = list(columns)
        """Kind, unit and texts of each signal, in the order in which they were given."""
        self.begin_ns = begin_ns
        """The instant at which the recording began."""
        self.lost = 0
        """Samples that are missing so far; always 0 in virtual time."""
        self._rows: list[Rows] = []
        self._times: dict[str, array[int]] = {column.name: array("q") for column in columns}
        self._values: dict[str, array[float]] = {column.name: array("d") for column in columns}
        self._whole: dict[str, dict[int, int]] = {column.name: {} for column in columns}

    @property
    def times_ns(self) -> "Mapping[str, array[int]]":
        """The instants of the samples of each signal, by its name."""
        self._take()
        return MappingProxyType(self._times)

    @property
    def values(self) -> "Mapping[str, array[float]]":
        """The values at these instants; NaN where the signal had none.  A text is its place in `Column.states`."""
        self._take()
        return MappingProxyType(self._values)

    @property
    def whole(self) -> Mapping[str, Mapping[int, int]]:
        """The exact values of whole numbers beyond 2^53, by the name of the signal and the place in its `values`."""
        self._take()
        return MappingProxyType(self._whole)

    @abstractmethod
    def end(self) -> None:
        """End the recording; what it has stays.  Ending twice does no harm."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def write_csv(self, file: str | Path) -> None:
        """Write a line for each instant, with the time in seconds and a column for each signal."""
        self._write(file, CsvFile)

    def write_vcd(self, file: str | Path) -> None:
        """Write a value change dump, which GTKWave and PulseView show."""
        self._write(file, VcdFile)

    def write_mf4(self, file: str | Path) -> None:
        """Write MF4 (ASAM MDF 4), a channel for each signal; UsageError without the extra `fieldrig[mf4]`."""
        self._write(file, Mf4File)

    def _write(self, file: str | Path, form: type[RowsFile]) -> None:
        self._take()
        with Path(file).open("wb") as stream:
            writer = form(stream, self.columns, self.begin_ns)
            for place, column in enumerate(self.columns):
                times_ns, values = self._times[column.name], self._values[column.name]
                whole = {(0, row): value for row, value in self._whole[column.name].items()}
                writer.take(Rows("", (place,), 0, 0, times_ns, [values], whole))
            writer.close()

    def _take(self) -> None:
        """Move what was sampled since the last call into the arrays."""
        count = len(self._rows)  # another thread may append
        rows, self._rows[:count] = self._rows[:count], ()
        for part in rows:
            self.lost += part.lost
            names = [self.columns[place].name for place in part.columns]
            for (column, row), value in part.whole.items():
                self._whole[names[column]][len(self._times[names[column]]) + row] = value
            for name, values in zip(names, part.values, strict=True):
                self._times[name].extend(part.times_ns)
                self._values[name].extend(values)


class LocalRecording(Recording):
    """A recording of a rig in virtual time in this process: nothing is lost."""

    def __init__(self, source: Source, signals: Sequence[str], rhythm: Rhythm) -> None:
        """ControlError for a signal that does not exist."""
        self._early: list[bytes] = []
        self._assembler: Assembler | None = None
        self._set = RecordSet(source, list(dict.fromkeys(signals)), rhythm, self._put, is_lossless=False)
        columns = [column._replace(states=list(column.states)) for column in self._set.columns]
        super().__init__(columns, source.now_ns())
        self._assembler = Assembler("", self._set.tracks, self.columns, self._rows.append)

    def end(self) -> None:
        self._set.end()

    def _put(self, data: bytes) -> None:
        self._set.acknowledge(self._set.next)
        if self._assembler is None:
            self._early.append(data)
        else:
            self._assembler.put(data)

    def _take(self) -> None:
        assert self._assembler is not None
        self._set.flush()
        early, self._early = self._early, []
        for data in early:
            self._assembler.put(data)
        super()._take()


class LiveRecording(Recording):
    """A recording of a rig in real time, in a thread that reads it."""

    def __init__(self, endpoint: str, rig: str, signals: Sequence[str], rhythm: Rhythm) -> None:
        """ControlError for a signal that does not exist, or a rig that does not answer."""
        early: list[Rows] = []
        self._reader = LiveReader(endpoint, rig, signals, rhythm, early.append)
        super().__init__(self._reader.columns, self._reader.begin_ns)
        self._rows = early

    @property
    def complete_ns(self) -> int:
        """The instant up to which everything has been handed over."""
        return self._reader.complete_ns

    def end(self) -> None:
        self._reader.end()
