"""The formats of traces: which there are, and which one a file has.

Our own format is `trace_jsonl`.  Others are modules of the same shape under the entry points "fieldrig.trace_formats".
A file that is written has the format of its ending.  One that is read is recognised by its beginning, as a `.log` may
be of Vector's tools, and a `.txt` of any.
"""

from collections.abc import Iterable, Iterator
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import BinaryIO, Final, Protocol, cast, runtime_checkable

from fieldrig.errors import UsageError
from fieldrig.text.nearest import closest
from fieldrig.traces import trace_jsonl
from fieldrig.traces.foreign import refuse_foreign
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.sparse_index import Clock
from fieldrig.traces.trace import TraceEntry

HEAD: Final = 4096
"""Bytes by which a format recognises a file."""


class Format(Protocol):
    SUFFIXES: tuple[str, ...]
    """The endings of names, the usual one first."""
    FAMILIES: frozenset[str]
    """The families of buses whose messages it can hold; empty if it can hold all."""

    def recognises(self, head: bytes) -> bool:
        """Return whether a file that begins like this is of the format; its last line may be cut."""

    def write(
        self, entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None
    ) -> int:
        """Write entries, and return how many; `start_unix_ns` is the time of day at their instant 0.

        Entries that the format cannot represent are left out, and what it cannot say of others is reported.
        """

    def read(self, file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
        """Yield the entries, and tell what is odd.  UsageError, with the place, for a file that cannot be read."""


@runtime_checkable
class WritesBack(Protocol):
    """A format that changes what it has written, so that a file is complete only at the end."""

    WRITES_BACK: bool


@runtime_checkable
class HasLines(Protocol):
    """A format of text whose lines have their times, so that reading can begin at one of them."""

    def line_clock(self, head: bytes) -> Clock | None:
        """Return how a line says its time; None for a log that has to be read from its beginning."""


def format_of(path: Path) -> Format:
    """Return the format of an ending.  UsageError, with the known endings, for an unknown one."""
    try:
        return _by_suffix()[path.suffix.lower()]
    except KeyError:
        endings = list(_by_suffix())
        near = closest(path.suffix.lower(), endings)
        remedy = near if near.startswith("did you mean") else f"there are: {_known()}"
        raise UsageError(f"{path}: no format of traces ends in {path.suffix!r}", remedy) from None


RIG_FILES = (".yaml", ".yml")


def format_of_file(suffix: str, head: bytes) -> Format:
    """Return the format of a file that begins with these bytes: what they show, or else what its ending `suffix` says.

    UsageError if neither is known.
    """
    by_suffix = _by_suffix().get(suffix.lower())
    candidates = ([by_suffix] if by_suffix else []) + [form for form in formats() if form is not by_suffix]
    found = next((form for form in candidates if form.recognises(head)), None)
    if found is None:
        refuse_foreign(suffix, head)
    if found is None and suffix.lower() in RIG_FILES:
        remedy = f"`fieldrig draw --rig` draws one, `fieldrig check` reads one; logs are {_known()}"
        raise UsageError("this is no log, but perhaps a rig file", remedy)
    if found is None and by_suffix is None:
        raise UsageError("no log of a known format", f"there are: {_known()}")
    return cast(Format, found or by_suffix)


@cache
def formats() -> tuple[Format, ...]:
    """Return all formats, our own first."""
    points = sorted(entry_points(group="fieldrig.trace_formats"), key=lambda point: point.name)
    return (cast(Format, trace_jsonl), *(cast(Format, point.load()) for point in points))


def _by_suffix() -> dict[str, Format]:
    return {suffix: form for form in formats() for suffix in form.SUFFIXES}


def _known() -> str:
    """Return the names of all formats with their endings."""
    names = {point.load(): point.name for point in entry_points(group="fieldrig.trace_formats")}
    return ", ".join(f"{names.get(form, 'JSON lines')} ({', '.join(form.SUFFIXES)})" for form in formats())
