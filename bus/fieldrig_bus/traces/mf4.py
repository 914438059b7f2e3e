"""MF4 (ASAM MDF 4) for CAN, by asammdf; fieldrig[mf4] installs it.

Messages are in the groups CAN_DataFrame, CAN_RemoteFrame and CAN_ErrorFrame of ASAM's standard for bus logging, with
the fields that python-can writes.  Python-can's own reader and writer are not used: they work only if asammdf was not
imported before them, the writer counts times from the instant of the conversion, and takes a tenth of a millisecond for
a frame.  Rows are written and read by the thousand here.  A time is a whole number of nanoseconds from the first
message, with a factor that makes seconds of it; floats, as python-can writes, are exact for a hundred days.  An error
frame has its class instead of an identifier, as python-can logs it.

The channel of `can0` is 0, as python-can has it; the names of buses are in the comment of the file.
"""

import gc
import html
import io
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import redirect_stdout
from datetime import UTC, datetime, timedelta
from decimal import Decimal
from heapq import merge
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO, Final

from fieldrig.clock import MS, US, S
from fieldrig.errors import UsageError
from fieldrig.traces.mf4_library import LINEAR, asammdf, count_nanoseconds
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import EXTENDED_MASK, FD_LENGTHS, STANDARD_MASK
from fieldrig_bus.can.linux_flags import ERROR
from fieldrig_bus.traces.beginning import beginning
from fieldrig_bus.traces.can_fields import Fields, fields_of, message_of
from fieldrig_bus.traces.channels import BusNames, Channels
from fieldrig_bus.traces.error_capture import unknown_error
from fieldrig_bus.traces.mf4_blocks import check
from fieldrig_bus.traces.named_file import path_to_read

SUFFIXES = (".mf4", ".mdf")
FAMILIES = frozenset({"can"})
WRITES_BACK = True
REMEDY: Final = "expected a recording of CAN in MDF 4"
ROWS: Final = 10_000
"""Rows that are written or read at once."""
DATA, ERRORS, REMOTES = "CAN_DataFrame", "CAN_ErrorFrame", "CAN_RemoteFrame"
_FIELDS: Final = (
    ("BusChannel", "u1"),
    ("ID", "<u4"),
    ("IDE", "u1"),
    ("DLC", "u1"),
    ("DataLength", "u1"),
    ("DataBytes", "(64,)u1"),
    ("Dir", "u1"),
    ("EDL", "u1"),
    ("BRS", "u1"),
)
"""The fields of a row, and the types of their numbers."""
_COMPRESSED: Final = 1
_FLOAT_STEP: Final = 256
"""Steps of a float of nanoseconds of our days: asammdf has the start of a file as one, if it is given a time of day."""


def recognises(head: bytes) -> bool:
    return head.startswith((b"MDF     4", b"UnFinMF 4"))


# ---- writing


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of messages."""
    library = asammdf()
    first, rest = beginning(entry for entry in entries if entry.family == "can")
    start_ns = start_unix_ns + min((entry.time_ns for entry in first), default=-start_unix_ns)
    start_ns = max(start_ns, 0)  # messages before 1970 have negative times then, which are floats
    writer = _Writer(library, start_ns - start_ns % MS)
    try:
        for entry in chain(first, rest):
            fields = fields_of(entry.data)
            if fields is not None:
                writer.add(start_unix_ns + entry.time_ns, entry.bus, fields)
        writer.save(file)
    finally:
        writer.close()
    return writer.written


class _Writer:
    def __init__(self, library: Any, start_ns: int) -> None:
        import numpy
        from asammdf.blocks.v4_blocks import SourceInformation
        from asammdf.blocks.v4_constants import BUS_TYPE_CAN, SOURCE_BUS

        self._numpy, self._start_ns = numpy, start_ns
        self._mdf = library.MDF(version="4.10")
        self._mdf.header.start_time = datetime.fromtimestamp(start_ns // S, tz=UTC) + timedelta(
            milliseconds=start_ns % S // MS
        )
        self._mdf.header.abs_time = start_ns  # which it has as a float
        self._channels = Channels()
        self._names: list[str] = []
        self._rows: dict[str, list[tuple[Any, ...]]] = {}
        self._times: dict[str, list[int]] = {}
        self._types: dict[str, Any] = {}
        self.written = 0
        for name in (DATA, ERRORS, REMOTES):
            self._types[name] = numpy.dtype([(f"{name}.{field}", kind) for field, kind in _FIELDS])
            self._rows[name], self._times[name] = [], []
            source = SourceInformation(source_type=SOURCE_BUS, bus_type=BUS_TYPE_CAN)
            empty = numpy.array([], dtype=self._types[name])
            self._mdf.append(library.Signal(name=name, samples=empty, timestamps=self._instants([]), source=source))
            count_nanoseconds(self._mdf, len(self._types) - 1)

    def add(self, time_ns: int, bus: str, fields: Fields) -> None:
        if self._channels.get(bus) is None:
            self._names.append(self._channels.add(bus))
        word, data, length, is_fd, is_switched = fields
        name = ERRORS if word & ERROR else REMOTES if word & REMOTE else DATA
        code = FD_LENGTHS.index(length)
        channel, is_extended = self._channels[bus] - 1, bool(word & EXTENDED)
        row = (
            channel,
            word & EXTENDED_MASK,
            is_extended,
            code,
            len(data),
            data.ljust(64, b"\0"),
            0,
            is_fd,
            is_switched,
        )
        self._rows[name].append(row)
        self._times[name].append(time_ns - self._start_ns)
        self.written += 1
        if len(self._rows[name]) >= ROWS:
            self._extend(name)

    def _extend(self, name: str) -> None:
        rows, times = self._rows[name], self._times[name]
        if not rows:
            return
        table = self._numpy.zeros(len(rows), dtype=self._types[name])
        for (field, _), values in zip(_FIELDS, zip(*rows, strict=True), strict=True):
            is_data = field == "DataBytes"
            column = self._numpy.frombuffer(b"".join(values), dtype="u1").reshape(-1, 64) if is_data else values
            table[f"{name}.{field}"] = column
        number = list(self._types).index(name)
        self._mdf.extend(number, [(self._instants(times), None), (table, None)])
        rows.clear()
        times.clear()

    def _instants(self, times_ns: list[int]) -> Any:
        return self._numpy.array(times_ns, dtype="<i8")

    def save(self, file: BinaryIO) -> None:
        for name in self._rows:
            self._extend(name)
        self._mdf.header.comment = "\n".join(self._names)
        self._mdf.save(file, compression=_COMPRESSED)

    def close(self) -> None:
        self._mdf.close()


# ---- reading


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Yield the entries.  A row that is no frame is odd; UsageError for a file that cannot be read."""
    odd = Oddities() if odd is None else odd
    odd.unit, odd.number = "row", 0
    with path_to_read(file) as path:
        with path.open("rb") as head:
            if not recognises(head.read(64)):
                raise UsageError("the file does not begin with the head of MDF 4", REMEDY)
            try:
                check(head)
            except ValueError as wrong:
                raise UsageError(f"not a whole file of MDF 4: {wrong}", REMEDY) from wrong
        library = asammdf()
        mdf = _opened(library, path)
        try:
            yield from _entries(mdf, odd)
        finally:
            mdf.close()


def _opened(library: Any, path: Path) -> Any:
    """Open a file.  UsageError for one that asammdf cannot read.

    Its object of such a file raises when it is deleted, and Python prints that; so it is deleted here, in silence.
    """
    hook = sys.unraisablehook
    sys.unraisablehook = lambda _unraisable: None
    try:
        try:
            # Otherwise it looks at all rows of buses for their identifiers, and has the whole file in memory meanwhile.
            with redirect_stdout(io.StringIO()):  # it prints a traceback of what it raises
                return library.MDF(path, process_bus_logging=False)
        except Exception as cause:  # noqa: BLE001  whatever its parser meets in bytes that are damaged
            reason = str(cause)
        gc.collect(1)  # it is young
    finally:
        sys.unraisablehook = hook
    raise UsageError(f"not a file of MDF 4: {reason}", REMEDY)


def _entries(mdf: Any, odd: Oddities) -> Iterator[TraceEntry]:
    try:
        start_ns, names = _start_ns(mdf), BusNames()
        for text in html.unescape(str(mdf.header.comment)).splitlines():
            names.learn(text)
        groups = [group for number in range(len(mdf.groups)) for group in _group(mdf, number, start_ns, names, odd)]
        yield from merge(*groups, key=lambda entry: entry.time_ns)
    except UsageError:
        raise
    except Exception as cause:  # as above: rows are read when they are asked for
        raise UsageError(f"after row {odd.number}: the file is damaged: {cause}", REMEDY) from cause


def _start_ns(mdf: Any) -> int:
    """Return the start, which asammdf gives to a microsecond and the header to a nanosecond."""
    seconds: float = mdf.header.start_time.timestamp()
    us, exact_ns = round(seconds * 1_000_000), int(mdf.header.abs_time)
    rest_ns = (exact_ns - us * US + S // 2) % S - S // 2  # the header may be in local time, whole seconds away
    was_float = exact_ns % _FLOAT_STEP == 0 and abs(rest_ns) < _FLOAT_STEP
    return us * US + (0 if was_float else rest_ns)


def _group(mdf: Any, number: int, start_ns: int, names: BusNames, odd: Oddities) -> list[Iterator[TraceEntry]]:
    """Return the messages of a group, if it has any."""
    group = mdf.groups[number]
    present = {channel.name for channel in group.channels}
    for name, make in ((DATA, _data), (ERRORS, _error), (REMOTES, _remote)):
        is_there = name in present or any(each.startswith(f"{name}.") for each in present)
        if is_there and group.channel_group.cycles_nr:
            return [_rows(mdf, number, name, make, start_ns, names, odd)]
    if group.channel_group.cycles_nr:
        odd.report("groups that are no CAN frames are left out")
    return []


def _rows(
    mdf: Any, number: int, name: str, make: Callable[..., bytes], start_ns: int, names: BusNames, odd: Oddities
) -> Iterator[TraceEntry]:
    for offset in range(0, mdf.groups[number].channel_group.cycles_nr, ROWS):
        with redirect_stdout(io.StringIO()):  # as above
            table, columns = _columns(mdf, number, name, offset)
            whole_ns = _whole_times_ns(mdf, number, offset)
        times_ns = whole_ns or [round(each * S) for each in table.timestamps.tolist()]
        for place, time_ns in enumerate(times_ns):
            odd.number += 1
            row = {field: values[place] for field, values in columns.items()}
            try:
                message = make(row)
            except (ValueError, IndexError) as wrong:
                odd.report("rows that cannot be read are left out", f": {wrong}")
                continue
            bus = names[int(row["BusChannel"]) + 1]
            yield TraceEntry(start_ns + time_ns, bus, "can", "", message)


def _columns(mdf: Any, number: int, name: str, offset: int) -> tuple[Any, dict[str, list[Any]]]:
    """Return some rows with their times, and the values of each field.

    The fields are parts of one channel, or channels of their own.  A field that the file does not have follows from
    others, or is 0.
    """
    channels = {channel.name for channel in mdf.groups[number].channels}
    fields = [field for field, _ in _FIELDS if f"{name}.{field}" in channels]

    def part(channel: str, *, is_raw: bool) -> Any:
        return mdf.get(channel, number, record_offset=offset, record_count=ROWS, raw=is_raw)

    is_whole = name in channels
    table = part(name, is_raw=False) if is_whole else part(f"{name}.{fields[0]}", is_raw=True)
    inside = (table.samples.dtype.names or ()) if is_whole else ()
    columns: dict[str, list[Any]] = {field: [0] * len(table.timestamps) for field, _ in _FIELDS}
    columns["DataBytes"] = [b""] * len(table.timestamps)
    for field in fields:
        channel = f"{name}.{field}"
        columns[field] = _column(table.samples[channel] if channel in inside else part(channel, is_raw=True).samples)
    if "DataLength" not in fields:
        by_code = [FD_LENGTHS[code & 15] for code in columns["DLC"]]
        columns["DataLength"] = by_code if "DLC" in fields else [len(data) for data in columns["DataBytes"]]
    if "IDE" not in fields:
        columns["IDE"] = [identifier > STANDARD_MASK for identifier in columns["ID"]]
    return table, columns


def _whole_times_ns(mdf: Any, number: int, offset: int) -> list[int]:
    """Return the instants of rows whose times are whole numbers of a unit, exactly; none if they are floats."""
    place = mdf.masters_db.get(number)
    conversion = None if place is None else mdf.groups[number].channels[place].conversion
    if conversion is None or conversion.conversion_type != LINEAR:
        return []
    raw, _ = mdf.get(group=number, index=place, record_offset=offset, record_count=ROWS, raw=True, samples_only=True)
    if raw.dtype.kind not in "iu":
        return []
    unit, first = (Decimal(repr(float(each))) * S for each in (conversion.a, conversion.b))
    if unit == int(unit) and first == int(first):
        whole_unit, whole_first = int(unit), int(first)
        return [each * whole_unit + whole_first for each in raw.tolist()]
    return [round(each * unit + first) for each in raw.tolist()]


def _column(values: Any) -> list[Any]:
    """Return the values of a field: numbers, or bytes where each value has several."""
    if values.dtype.kind in "SV":
        values = values.view("u1").reshape(len(values), -1)
    return values.tolist() if values.ndim == 1 else [value.tobytes() for value in values]


def _word(row: dict[str, Any]) -> int:
    number = int(row["ID"])
    return number & EXTENDED_MASK | (EXTENDED if row["IDE"] or number >> 31 else 0)


def _data(row: dict[str, Any]) -> bytes:
    data = row["DataBytes"][: row["DataLength"]]
    is_fd = bool(row["EDL"]) or len(data) > 8
    return message_of(_word(row), data, is_fd=is_fd, is_switched=is_fd and bool(row["BRS"])) or b""


def _remote(row: dict[str, Any]) -> bytes:
    return message_of(_word(row) | REMOTE, b"", FD_LENGTHS[row["DLC"] & 15] or row["DataLength"]) or b""


def _error(row: dict[str, Any]) -> bytes:
    data = row["DataBytes"][: row["DataLength"]]
    return message_of(int(row["ID"]) & EXTENDED_MASK | ERROR, data) or encode(unknown_error())
