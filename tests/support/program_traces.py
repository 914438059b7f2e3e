"""The questions of a debugger, with its traces, to a device of a rig in virtual time in this process."""

from collections.abc import Mapping, Sequence
from typing import Any

from fieldrig.errors import ControlError
from fieldrig.recording.reader import Assembler, OnRows
from fieldrig.recording.record_set import RecordSet
from fieldrig.recording.signals import CYCLE
from fieldrig.virtual.recorded import RigSource
from fieldrig.virtual.rig import Rig
from fieldrig_devices.languages.debugging.traces import Traces


class RigTraces:
    """A function for questions, as `with_traces` makes it of a running rig."""

    def __init__(self, rig: Rig, device: str) -> None:
        self.rig, self._device = rig, device
        self.recordings: list[_Recording] = []
        """The recordings that have not ended."""
        self._traces = Traces(self._ask_device, self.begin)

    def __call__(self, message: Mapping[str, Any]) -> dict[str, Any]:
        for recording in self.recordings:
            recording.flush()
        try:
            answer = self._traces.answer(message)
            return self._ask_device(message) if answer is None else answer
        except ControlError as cause:
            raise ValueError(str(cause)) from None

    def _ask_device(self, message: Mapping[str, Any]) -> dict[str, Any]:
        answer: dict[str, Any] = self.rig.answer(self._device, "debug", message)
        return answer

    def begin(self, keys: Sequence[str], on_rows: OnRows) -> "_Recording":
        recording = _Recording(self.rig, [f"{self._device}/{key}" for key in keys], on_rows, self.recordings)
        self.recordings.append(recording)
        return recording


class _Recording:
    def __init__(self, rig: Rig, signals: Sequence[str], on_rows: OnRows, all_of_them: "list[_Recording]") -> None:
        self._set = RecordSet(RigSource(rig), signals, CYCLE, self._put, is_lossless=True)
        self._all = all_of_them
        self.columns = [column._replace(states=list(column.states)) for column in self._set.columns]
        self._assembler = Assembler("", self._set.tracks, self.columns, on_rows)

    def _put(self, data: bytes) -> None:
        self._set.acknowledge(self._set.next)
        self._assembler.put(data)

    def flush(self) -> None:
        self._set.flush()

    def end(self) -> None:
        self._set.close()
        self._all.remove(self)
