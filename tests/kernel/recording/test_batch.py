"""Batches of recorded values as bytes (`fieldrig.recording.batch` describes them)."""

import math
import struct
from array import array
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.outside.untrusted import MalformedError
from fieldrig.recording import batch
from fieldrig.recording.batch import Kind

INSTANTS = st.integers(-(1 << 63), (1 << 63) - 1)
VALUES = st.floats(width=64)
COUNTS = st.integers(0, (1 << 64) - 1)
TRACKS = st.integers(0, (1 << 16) - 1)


def test_a_batch_has_the_bytes_of_its_description() -> None:
    rows = struct.pack("<2d", 1.5, -2.0)
    parts = [
        batch.rows_part(3, 7, 1, [10], 2, rows),
        batch.events_part(4, 9, [(11, 5, 0.5)]),
        batch.texts_part(2, b"[]"),
    ]
    parts.append(batch.events_part(4, 0, [(9, 5, -1.0)], Kind.WHOLE))
    expected = (
        "0200000000000000 0c00000000000000 04000000 00000000"
        "0300 0000 01000000 02000000 00000000 0700000000000000 0100000000000000"
        "0a00000000000000 000000000000f83f 00000000000000c0"
        "0400 0100 01000000 01000000 00000000 0900000000000000 0000000000000000"
        "0b00000000000000 000000000000e03f 05000000"
        "0200 0200 02000000 00000000 00000000 0000000000000000 0000000000000000 5b5d"
        "0400 0300 01000000 01000000 00000000 0000000000000000 0000000000000000"
        "0900000000000000 000000000000f0bf 05000000"
    )
    assert batch.encode(2, 12, parts) == bytes.fromhex(expected)


@given(COUNTS, INSTANTS, TRACKS, COUNTS, COUNTS, st.lists(st.tuples(INSTANTS, VALUES, VALUES)))
def test_rows_are_read_as_they_were_written(
    number: int, until_ns: int, track: int, first: int, missed: int, rows: list[tuple[int, float, float]]
) -> None:
    data = b"".join(struct.pack("<2d", *values) for _, *values in rows)
    read = batch.decode(
        batch.encode(number, until_ns, [batch.rows_part(track, first, missed, [row[0] for row in rows], 2, data)])
    )
    (part,) = read.parts
    assert (read.number, read.until_ns) == (number, until_ns)
    assert part[:5] == (track, Kind.ROWS, first, missed, array("q", [row[0] for row in rows]))
    assert [column.tobytes() for column in part.values] == [
        array("d", [row[column] for row in rows]).tobytes() for column in (1, 2)
    ]


@given(TRACKS, COUNTS, st.lists(st.tuples(INSTANTS, st.integers(0, (1 << 32) - 1), VALUES)))
def test_events_are_read_as_they_were_written(track: int, first: int, events: list[tuple[int, int, float]]) -> None:
    (part,) = batch.decode(batch.encode(0, 0, [batch.events_part(track, first, events)])).parts
    assert (part.track, part.kind, part.first) == (track, Kind.EVENTS, first)
    read = zip(part.times_ns, part.columns, part.values[0], strict=True)
    assert [(time_ns, column, math.isnan(value) or value) for time_ns, column, value in read] == [
        (time_ns, column, math.isnan(value) or value) for time_ns, column, value in events
    ]


@given(st.binary())
def test_any_bytes_are_a_batch_or_are_refused(data: bytes) -> None:
    for read in (batch.decode, batch.unbundle, batch.number_of):
        try:
            read(data)
        except MalformedError:
            continue


@given(st.data())
def test_a_batch_that_was_cut_or_changed_is_read_or_refused(data: st.DataObject) -> None:
    whole = batch.encode(1, 2, [batch.rows_part(0, 0, 0, [1, 2], 1, bytes(16)), batch.events_part(1, 0, [(1, 0, 2.0)])])
    cut = data.draw(st.integers(0, len(whole) - 1))
    with pytest.raises(MalformedError):
        batch.decode(whole[:cut])
    place, value = data.draw(st.integers(0, len(whole) - 1)), data.draw(st.integers(0, 255))
    with suppress(MalformedError):
        batch.decode(whole[:place] + bytes([value]) + whole[place + 1 :])


@given(st.lists(st.binary()))
def test_a_bundle_has_its_batches(batches: list[bytes]) -> None:
    assert batch.unbundle(batch.bundle(batches)) == batches
