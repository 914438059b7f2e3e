"""The traces of one debugger: recordings of the kernel, of which a recorder here keeps what was asked for.

The device knows nothing of them.  Its variables are recorded as `program:NAME` at the end of each cycle, beside the
recordings of pages, tests and other debuggers.  This debugger is the owner of its own, so they end with it.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Final, Protocol

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError, field, items, shown, typed
from fieldrig.recording.reader import OnRows, Rows
from fieldrig.recording.signals import Column, Sort
from fieldrig_devices.languages.debugging.adapter import Ask
from fieldrig_devices.languages.debugging.recorder import MOST_VALUES, Edge, Recorder, RecorderState, Trigger
from fieldrig_devices.languages.debugging.service import PROGRAM, choice

LONGEST_TRACE_NAME: Final = 64

Answer = dict[str, Any]


class Recording(Protocol):
    """A recording of the kernel that has begun, as `recording.live_reader.LiveReader` is."""

    @property
    def columns(self) -> Sequence[Column]: ...

    def end(self) -> None: ...


Begin = Callable[[Sequence[str], OnRows], Recording]
"""Begins to record these keys of the device in each of its cycles.  ControlError if that is not possible."""


class _Trace:
    """One trace: a recording, and the recorder that gets its rows."""

    def __init__(self, names: list[str], signals: Sequence[str], are_whole: Sequence[bool], recorder: Recorder) -> None:
        """`signals` are the names, and the one of the trigger behind them."""
        self.names, self.recorder = names, recorder
        self._signals, self._are_whole = list(dict.fromkeys(signals)), dict(zip(signals, are_whole, strict=True))
        self._places = [self._signals.index(name) for name in signals]
        self._rows: list[Rows] = []
        self._recording: Recording | None = None
        self.lost = 0
        """Rows that are missing, because the host was late or the program's process was restarted."""

    def begin(self, begin: Begin) -> None:
        self._recording = begin([f"{PROGRAM}{name}" for name in self._signals], self._rows.append)

    def end(self) -> None:
        if self._recording is not None:
            self._recording.end()

    def take(self) -> None:
        """Give the rows that have come to the recorder."""
        if self._recording is None:
            return
        count = len(self._rows)  # another thread may append
        come, self._rows[:count] = self._rows[:count], ()
        for rows in come:
            self.lost += rows.lost
            columns = [
                self._read(column, values) for column, values in zip(self._recording.columns, rows.values, strict=True)
            ]
            for row, (now_ns, *values) in enumerate(zip(rows.times_ns, *columns, strict=True)):
                self.recorder.take(now_ns, [rows.whole.get((place, row), values[place]) for place in self._places])

    def _read(self, column: Column, values: Iterable[float]) -> Iterator[Value | None]:
        """Yield the values of a column as the program has them; None where there was none."""
        is_whole = self._are_whole[column.name.partition(PROGRAM)[2]]
        for value in values:
            if math.isnan(value):
                yield None
            elif column.kind is Sort.TEXT:
                yield column.states[int(value)]
            elif column.kind is Sort.TRUTH:
                yield bool(value)
            else:
                yield int(value) if is_whole and not math.isinf(value) else value


class Traces:
    """Answers the questions `record` and `samples` of one debugger."""

    def __init__(self, ask: Ask, begin: Begin) -> None:
        self._ask, self._begin = ask, begin
        self._traces: dict[str, _Trace] = {}

    def answer(self, message: Mapping[str, Any]) -> Answer | None:
        """Answer a question; None if it is not about traces.  ValueError, saying what was expected, for a wrong one.

        ControlError if the device has no such value.
        """
        match message.get("command"):
            case "record":
                return self._record(message)
            case "samples":
                return self._samples(message)
        return None

    def end(self) -> None:
        """End all traces."""
        for own in tuple(self._traces):
            self._end(own)

    def _end(self, own: str) -> None:
        trace = self._traces.pop(own, None)
        if trace is not None:
            trace.end()

    def _record(self, message: Mapping[str, Any]) -> Answer:
        """Begin a trace of `names`, or end it if there are none; `trace` is its name, as there may be several."""
        names = items(field(message, "names", list), str, MOST_VALUES, "names")
        own = _trace_name(message)
        if not names:
            self._end(own)
            return {"names": []}
        signals = list(names)
        trigger = self._trigger(message["trigger"], signals) if message.get("trigger") is not None else None
        recorder = Recorder(
            len(names),
            every=typed(message.get("every", 1), int, "every"),
            depth=typed(message.get("depth", 1_000), int, "depth"),
            trigger=trigger,
        )
        are_whole = self._are_whole(signals)
        self._end(own)
        trace = _Trace(names, signals, are_whole, recorder)
        trace.begin(self._begin)
        self._traces[own] = trace
        return {"names": names}

    def _trigger(self, wanted: Any, signals: list[str]) -> Trigger:
        edge = choice(Edge, wanted.get("edge", Edge.RISING.value) if isinstance(wanted, dict) else None, "edge")
        level = typed(wanted.get("level", 0.0), float, "level")
        before = typed(wanted.get("before", 0), int, "before")
        signals.append(field(wanted, "name", str))
        return Trigger(len(signals) - 1, edge, level, before)

    def _are_whole(self, names: Sequence[str]) -> list[bool]:
        """Return true for each of these names that is a whole number.  ControlError for one that is no single value."""
        found = []
        for name, variable in zip(names, self._ask({"command": "read", "names": names})["variables"], strict=True):
            if "error" in variable:
                what, _, remedy = str(variable["error"]).partition("\n")
                raise ControlError(what, remedy)
            if variable["value"] is None:
                raise ControlError(f"{shown(name)} is a group of values", "expected a single value")
            found.append(type(variable["value"]) is int)
        return found

    def _samples(self, message: Mapping[str, Any]) -> Answer:
        own = _trace_name(message)
        if own not in self._traces:
            raise ValueError("no trace was begun\nexpected `record` before it")
        trace = self._traces[own]
        trace.take()
        recorder = trace.recorder
        after = typed(message.get("after", 0), int, "after")
        return {
            "names": trace.names,
            "state": recorder.state.value,
            "is_full": recorder.state is RecorderState.FULL,
            "triggered_ns": recorder.triggered_ns,
            "taken": recorder.taken,
            "lost": trace.lost,
            "samples": [[now_ns, *values] for now_ns, values in recorder.samples(after)],
        }


@contextmanager
def with_traces(ask: Ask, begin: Begin) -> Iterator[Ask]:
    """Return a function that answers questions about traces here, and puts all others to the service.

    All traces end with the context.
    """
    traces = Traces(ask, begin)

    def answer(message: Mapping[str, Any]) -> Answer:
        own = traces.answer(message)
        return ask(message) if own is None else own

    try:
        yield answer
    finally:
        traces.end()


def _trace_name(message: Mapping[str, Any]) -> str:
    """Return the asker's name of a trace; without one, it has a single trace."""
    name = typed(message.get("trace", ""), str, "trace")
    if len(name) > LONGEST_TRACE_NAME:
        raise MalformedError(f"trace: {len(name)} characters, expected at most {LONGEST_TRACE_NAME}")
    return name
