"""Batches of recorded values as a process publishes them, little endian.

    head    uint64 number of the batch, int64 instant up to which it is complete, uint32 number of parts, 4 bytes of 0
    part    uint16 track, uint16 kind, uint32 rows, uint32 columns, 4 bytes of 0, uint64 number of the first row of the
            track, uint64 rows that the host has missed in the track so far
    ROWS    int64 instant of each row, then float64 for each column of each row
    EVENTS  int64 instant of each row, float64 value of each row, uint32 column of each row
    WHOLE   as EVENTS, with the number of a row instead of its instant, and what is to be added to the value there: a
            whole number that float64 has rounded; before the rows of its track
    TEXTS   JSON of `rows` bytes: the texts that a column has had since the last batch, whose values are their places

A bundle is batches one after the other, each with its uint32 length before it.
"""

import struct
import sys
from array import array
from collections.abc import Iterable, Sequence
from enum import IntEnum
from typing import Any, Final, NamedTuple

from fieldrig.outside.untrusted import MalformedError

HEAD: Final = struct.Struct("<QqI4x")
PART: Final = struct.Struct("<HHII4xQQ")
LENGTH: Final = struct.Struct("<I")
LONGEST: Final = 16 << 20
"""Longest batch in bytes; a longer one is not read."""
MOST_COLUMNS: Final = 65_536


class Kind(IntEnum):
    ROWS = 0
    EVENTS = 1
    TEXTS = 2
    WHOLE = 3


class Part(NamedTuple):
    """The rows, events or texts that one track has in one batch."""

    track: int
    kind: Kind
    first: int
    """Number of the first row among all rows of the track."""
    missed: int
    """Rows of the track that the host was too late for, from the beginning to the last of these rows."""
    times_ns: "array[int]"
    """WHOLE: the numbers of the rows."""
    values: "list[array[float]]"
    """ROWS: a column each, as long as `times_ns`.  EVENTS: one value for each row.  WHOLE: what to add to each."""
    columns: "array[int]"
    """EVENTS and WHOLE: the column of each row."""
    text: bytes = b""
    """TEXTS: the JSON."""


class Batch(NamedTuple):
    number: int
    until_ns: int
    """Everything up to this instant is in this batch or in earlier ones."""
    parts: list[Part]


def rows_part(track: int, first: int, missed: int, times_ns: Sequence[int], columns: int, rows: bytes) -> bytes:
    """Return the part of a track whose rows are float64 values one after the other."""
    count = len(times_ns)
    head = PART.pack(track, Kind.ROWS, count, columns, first, missed)
    return b"".join((head, struct.pack(f"<{count}q", *times_ns), rows))


def events_part(track: int, first: int, events: Sequence[tuple[int, int, float]], kind: Kind = Kind.EVENTS) -> bytes:
    """Return the part of a track with events: instant (for WHOLE, number of the row), column and value."""
    count = len(events)
    times_ns, columns, values = zip(*events, strict=True) if events else ((), (), ())
    return b"".join(
        (
            PART.pack(track, kind, count, 1, first, 0),
            struct.pack(f"<{count}q", *times_ns),
            struct.pack(f"<{count}d", *values),
            struct.pack(f"<{count}I", *columns),
        )
    )


def texts_part(track: int, text: bytes) -> bytes:
    return PART.pack(track, Kind.TEXTS, len(text), 0, 0, 0) + text


def encode(number: int, until_ns: int, parts: Sequence[bytes]) -> bytes:
    return b"".join((HEAD.pack(number, until_ns, len(parts)), *parts))


def number_of(data: bytes) -> int:
    """Return the number of a batch.  MalformedError for fewer bytes than a head has."""
    if len(data) < HEAD.size:
        raise MalformedError(f"{len(data)} bytes, expected the head of a batch")
    number: int = HEAD.unpack_from(data)[0]
    return number


def decode(data: bytes) -> Batch:
    """Return the batch of these bytes.  MalformedError for anything but a whole batch."""
    if not HEAD.size <= len(data) <= LONGEST:
        raise MalformedError(f"{len(data)} bytes, expected a batch of at most {LONGEST}")
    number, until_ns, count = HEAD.unpack_from(data)
    parts: list[Part] = []
    at = HEAD.size
    while len(parts) < count:
        part, at = _part(data, at)
        parts.append(part)
    if at != len(data):
        raise MalformedError(f"{len(data) - at} bytes after the last part of a batch")
    return Batch(number, until_ns, parts)


def _part(data: bytes, at: int) -> tuple[Part, int]:
    if at + PART.size > len(data):
        raise MalformedError("a batch ends within the head of a part")
    track, kind, rows, columns, first, missed = PART.unpack_from(data, at)
    at += PART.size
    sizes = {Kind.ROWS: rows * 8 * (1 + columns), Kind.EVENTS: rows * 20, Kind.WHOLE: rows * 20, Kind.TEXTS: rows}
    if kind not in sizes or columns > MOST_COLUMNS:
        raise MalformedError(f"a part of kind {kind} with {columns} columns")
    end = at + sizes[kind]
    if end > len(data):
        raise MalformedError(f"a batch ends {end - len(data)} bytes before its part")
    if kind == Kind.TEXTS:
        return Part(track, Kind.TEXTS, first, missed, array("q"), [], array("I"), data[at:end]), end
    times_ns, at = _array("q", data, at, rows)
    if kind in (Kind.EVENTS, Kind.WHOLE):
        values, at = _array("d", data, at, rows)
        of_columns, at = _array("I", data, at, rows)
        return Part(track, Kind(kind), first, missed, times_ns, [values], of_columns), end
    flat, at = _array("d", data, at, rows * columns)
    return Part(track, Kind.ROWS, first, missed, times_ns, [flat[n::columns] for n in range(columns)], array("I")), end


def _array(code: str, data: bytes, at: int, count: int) -> "tuple[array[Any], int]":
    found: array[Any] = array(code)
    end = at + count * found.itemsize
    found.frombytes(data[at:end])
    if sys.byteorder == "big":
        found.byteswap()
    return found, end


def bundle(batches: Iterable[bytes]) -> bytes:
    return b"".join(part for batch in batches for part in (LENGTH.pack(len(batch)), batch))


def unbundle(data: bytes) -> list[bytes]:
    """Return the batches of a bundle.  MalformedError for anything else."""
    batches: list[bytes] = []
    at = 0
    while at < len(data):
        if at + LENGTH.size > len(data):
            raise MalformedError("a bundle of batches ends within a length")
        (length,) = LENGTH.unpack_from(data, at)
        at += LENGTH.size
        if at + length > len(data):
            raise MalformedError("a bundle of batches ends within a batch")
        batches.append(data[at : at + length])
        at += length
    return batches
