"""Traces in files: read and written whole, or in a part of their time.

Reading takes constant memory, whatever the length of the file.
"""

from collections.abc import Iterable, Iterator
from io import BufferedReader
from pathlib import Path
from typing import BinaryIO, Final

from fieldrig.errors import UsageError
from fieldrig.system.whole_file import whole_file
from fieldrig.text.nearest import nearest_file
from fieldrig.traces.formats import HEAD, Format, HasLines, format_of, format_of_file
from fieldrig.traces.oddities import Oddities, with_jumps_reported
from fieldrig.traces.old_line_ends import has_old_line_ends, with_line_feeds
from fieldrig.traces.sparse_index import jumped
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.window import within

REMEDY: Final = "name a file in a folder that is there, on a disk that has room"


def read(
    path: Path, begin_ns: int | None = None, duration_ns: int | None = None, odd: Oddities | None = None
) -> Iterator[TraceEntry]:
    """Yield the entries of a file, from `begin_ns` for `duration_ns`; None is its beginning, or its end.

    `begin_ns` counts from the first message, or from the start of a rig in virtual time.  What is odd in the file is
    reported to `odd`.  UsageError, with the place, if it cannot be read, or is not a trace.
    """
    odd = Oddities() if odd is None else odd
    try:
        with path.open("rb") as file:
            content, head = _content(file)
            form = format_of_file(path.suffix, head)
            source = _from(content, form, head, begin_ns, odd) if begin_ns else content
            entries = with_jumps_reported(form.read(source, odd), odd)
            if begin_ns is None and duration_ns is None:
                yield from entries
            else:
                yield from within(entries, begin_ns, duration_ns)
    except OSError as cause:
        raise UsageError(f"{path} cannot be read: {cause.strerror}", nearest_file(path)) from cause
    except UsageError as wrong:
        raise UsageError(f"{path}: {wrong.what}", wrong.remedy) from wrong


def _content(file: BufferedReader) -> tuple[BinaryIO, bytes]:
    """Return the file with lines that end as others do, and its first bytes."""
    head = file.peek(HEAD)[:HEAD]
    return (with_line_feeds(file), head.replace(b"\r", b"\n")) if has_old_line_ends(head) else (file, head)


def _from(file: BinaryIO, form: Format, head: bytes, begin_ns: int, odd: Oddities) -> BinaryIO:
    """Return the file from shortly before a time on, if its lines say their times."""
    clock = form.line_clock(head) if isinstance(form, HasLines) and file.seekable() else None
    return file if clock is None else jumped(file, head, clock, begin_ns, odd)


def read_trace(
    path: str | Path, begin: int | None = None, duration: int | None = None, oddities: Oddities | None = None
) -> Iterator[TraceEntry]:
    """Yield the messages of a recording in any format, in the order of the file.

    `begin` and `duration` are in nanoseconds, and choose a part of its time: `begin` counts from the first message, or
    from the start of the rig in a trace of virtual time.  What is odd in the file (a cut last line, a jump back in
    time) is reported to `oddities`.  UsageError, with file and place, if the file is no recording.
    """
    return read(Path(path), begin, duration, oddities)


def write(entries: Iterable[TraceEntry], path: Path, odd: Oddities | None = None) -> int:
    """Write entries, which have the time of day, and return how many; a format may not know every family.

    What the format cannot say of the others is reported to `odd`.  If the entries or the disk fail, the target stays as
    it was.
    """
    form = format_of(path)
    try:
        with whole_file(path) as file:
            return form.write(entries, file, 0, odd)
    except OSError as cause:
        raise UsageError(f"{path} cannot be written: {cause.strerror}", REMEDY) from cause
