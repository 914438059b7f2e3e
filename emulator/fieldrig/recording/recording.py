"""A recording of a rig in virtual time in the same process: nothing is lost, and everything stays in memory.

with Rig(load("rig.yaml")) as rig:
    recording = rig.record(["drive/position", "wires/lamp.on"])
    rig.run_for(2 * S)
    assert max(recording.values["drive/position"]) < 1000
    recording.write_csv("drive.csv")
"""

from array import array
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from fieldrig.recording.files import CsvFile, RowsFile, VcdFile
from fieldrig.recording.reader import Assembler, Rows
from fieldrig.recording.record_set import RecordSet
from fieldrig.recording.signals import Column, Rhythm, Source


class Recording:
    """Signals of a rig from `Rig.record` until `end`, or until the rig is closed."""

    def __init__(self, source: Source, signals: Sequence[str], rhythm: Rhythm) -> None:
        """ControlError for a signal that does not exist.  `rhythm`: see `Rig.record`."""
        names = list(dict.fromkeys(signals))
        self.begin_ns = source.now_ns()
        """The instant at which the recording began."""
        self._rows: list[Rows] = []
        self._early: list[bytes] = []
        self._assembler: Assembler | None = None
        self._set = RecordSet(source, names, rhythm, self._put, is_lossless=False)
        self.columns: list[Column] = [column._replace(states=list(column.states)) for column in self._set.columns]
        """Kind, unit and texts of each signal, in the order in which they were given."""
        self._assembler = Assembler("", self._set.tracks, self.columns, self._rows.append)
        self._times = {name: array("q") for name in names}
        self._values = {name: array("d") for name in names}

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

    def end(self) -> None:
        """End the recording; what it has stays."""
        self._set.end()

    def write_csv(self, file: str | Path) -> None:
        """Write a line for each instant, with the time in seconds and a column for each signal."""
        self._write(file, CsvFile)

    def write_vcd(self, file: str | Path) -> None:
        """Write a value change dump, which GTKWave and PulseView show."""
        self._write(file, VcdFile)

    def _write(self, file: str | Path, format_of: Any) -> None:
        self._take()
        with Path(file).open("wb") as stream:
            writer: RowsFile = format_of(stream, self.columns, self.begin_ns)
            for place, column in enumerate(self.columns):
                times_ns, values = self._times[column.name], self._values[column.name]
                writer.take(Rows("", (place,), 0, 0, times_ns, [values]))
            writer.close()

    def _put(self, data: bytes) -> None:
        self._set.acknowledge(self._set.next)
        if self._assembler is None:
            self._early.append(data)
        else:
            self._assembler.put(data)

    def _take(self) -> None:
        """Move what was sampled since the last call into the arrays."""
        assert self._assembler is not None
        self._set.flush()
        early, self._early = self._early, []
        for data in early:
            self._assembler.put(data)
        rows, self._rows[:] = tuple(self._rows), ()
        for part in rows:
            for place, values in zip(part.columns, part.values, strict=True):
                name = self.columns[place].name
                self._times[name].extend(part.times_ns)
                self._values[name].extend(values)
