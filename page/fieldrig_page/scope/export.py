"""Captures as files: CSV for spreadsheets, and a value change dump for GTKWave and PulseView.

They are those of `fieldrig record` (`fieldrig.recording.files`), from the first instant of the capture on.  A gap is a
row without values.
"""

from io import BytesIO
from typing import Final

from fieldrig.recording.files import CsvFile, RowsFile, VcdFile
from fieldrig.recording.reader import Rows
from fieldrig.recording.signals import Column, Sort
from fieldrig_page.scope.captures import Capture, Trace

FORMATS: Final[dict[str, type[RowsFile]]] = {"csv": CsvFile, "vcd": VcdFile}


def exported(capture: Capture, form: str) -> bytes:
    """Return a capture as a file of one of the `FORMATS`."""
    file, traces = BytesIO(), list(capture.traces.values())
    columns = [Column(one.name, Sort(one.kind), one.unit, list(one.states), is_held=one.holds) for one in traces]
    writer = FORMATS[form](file, columns, capture.first_ns)
    for place, trace in enumerate(traces):
        writer.take(_rows(trace, place, capture.first_ns))
    writer.close(capture.end_ns)
    return file.getvalue()


def _rows(trace: Trace, place: int, first_ns: int) -> Rows:
    """The samples of a signal, and for a value that holds the one before the first instant."""
    track = trace.track
    first = track.position(first_ns)
    has_its_own = first < len(track.times_ns) and track.times_ns[first] == first_ns
    if trace.holds and not has_its_own:
        first = max(first - 1, 0)
    number = track.base + first
    whole = {(0, at - number): value for (column, at), value in track.whole.items() if column == trace.column}
    return Rows("", (place,), 0, 0, track.times_ns[first:], [track.values[trace.column][first:]], whole)
