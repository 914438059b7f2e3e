"""Batches that come late, twice, in another order or not at all become rows in order, each once."""

import struct
from array import array
from contextlib import suppress

from hypothesis import given
from hypothesis import strategies as st

from fieldrig.outside.untrusted import MalformedError
from fieldrig.recording import batch
from fieldrig.recording.reader import Assembler, Rows
from fieldrig.recording.signals import Column, Sort

TRACKS = [[0, 1], [2]]


def batches_of(sizes: list[int]) -> list[bytes]:
    """Return batches whose rows count from 0: two columns in track 0, and a column of events in track 1."""
    batches, first = [], 0
    for number, size in enumerate(sizes):
        places = range(first, first + size)
        rows = b"".join(struct.pack("<2d", place, -place) for place in places)
        parts = [
            batch.rows_part(0, first, 0, list(places), 2, rows),
            batch.events_part(1, first, [(place, 0, place / 2) for place in places]),
        ]
        batches.append(batch.encode(number, first + size, parts if size else []))
        first += size
    return batches


class Bench:
    def __init__(self) -> None:
        self.rows: list[Rows] = []
        kinds = {"a/x": Sort.NUMBER, "a/y": Sort.TEXT, "b/z": Sort.NUMBER}
        self.columns = [Column(name, kind, "", []) for name, kind in kinds.items()]
        self.assembler = Assembler("p", TRACKS, self.columns, self.rows.append)

    def column(self, number: int) -> list[float]:
        found = array("d")
        for rows in self.rows:
            if number in rows.columns:
                found.extend(rows.values[rows.columns.index(number)])
        return list(found)


SIZES = st.lists(st.integers(0, 4), min_size=1, max_size=12)


@given(SIZES, st.data())
def test_batches_in_any_order_and_several_times_are_handed_over_in_order_and_once(
    sizes: list[int], data: st.DataObject
) -> None:
    bench, batches = Bench(), batches_of(sizes)
    doubled = data.draw(st.lists(st.sampled_from(batches)))
    for each in data.draw(st.permutations([*batches, *doubled])):
        bench.assembler.put(each)
    assert bench.column(0) == [float(number) for number in range(sum(sizes))]
    assert bench.column(1) == [-float(number) for number in range(sum(sizes))]
    assert bench.column(2) == [number / 2 for number in range(sum(sizes))]
    assert bench.assembler.gap is None
    assert bench.assembler.complete_ns == sum(sizes)
    assert sum(rows.lost for rows in bench.rows) == 0


@given(SIZES, st.data())
def test_what_is_lost_for_good_is_counted(sizes: list[int], data: st.DataObject) -> None:
    sizes = [*sizes, 1]  # what is lost is seen by the rows after it
    bench, batches = Bench(), batches_of(sizes)
    lost = data.draw(st.sets(st.integers(0, len(batches) - 2)))
    for number, each in enumerate(batches):
        if number not in lost:
            bench.assembler.put(each)
    while (gap := bench.assembler.gap) is not None:
        bench.assembler.lose_until(gap[1])
    expected = sum(sizes[number] for number in lost)
    assert sum(rows.lost for rows in bench.rows if 0 in rows.columns) == expected
    assert sum(rows.lost for rows in bench.rows if 2 in rows.columns) == expected
    assert len(bench.column(0)) == sum(sizes) - expected


def test_rows_that_the_host_was_too_late_for_are_lost_too() -> None:
    bench = Bench()
    for number, missed in enumerate((0, 3, 3)):
        part = batch.rows_part(0, number, missed, [number], 2, bytes(16))
        bench.assembler.put(batch.encode(number, 0, [part]))
    assert [rows.lost for rows in bench.rows] == [0, 3, 0]


@given(st.binary(max_size=200))
def test_bytes_that_are_no_batch_change_nothing(junk: bytes) -> None:
    bench = Bench()
    with suppress(MalformedError):
        batch.decode(junk)
        return  # by chance it is one
    bench.assembler.put(junk)
    bench.assembler.put(batches_of([2])[0])
    assert bench.column(0)[-2:] == [0.0, 1.0]


def test_texts_of_a_column_come_before_the_values_that_stand_for_them() -> None:
    bench = Bench()
    part = batch.rows_part(0, 0, 0, [1], 2, struct.pack("<2d", 0.0, 1.0))
    bench.assembler.put(batch.encode(0, 1, [batch.texts_part(1, b'["off", "on"]'), part]))
    assert bench.columns[1].states[int(bench.column(1)[0])] == "on"
    for junk in (b"{", b'{"a": 1}', b"[1]", b"\xff"):
        bench.assembler.put(
            batch.encode(bench.assembler.next, 1, [batch.texts_part(1, junk), batch.texts_part(9, b"[]")])
        )
    assert bench.columns[1].states == ["off", "on"]


def rows_of_zeros(track: int, first: int, missed: int, count: int) -> bytes:
    return batch.rows_part(track, first, missed, [0] * count, 2, bytes(16 * count))


INTS = st.integers(0, 5)
PARTS = st.one_of(
    st.builds(rows_of_zeros, INTS, INTS, INTS, INTS),
    st.builds(batch.events_part, INTS, INTS, st.lists(st.tuples(INTS, INTS, st.floats()))),
    st.builds(batch.texts_part, INTS, st.binary(max_size=9) | st.just(b'["off","on"]')),
)


@given(st.lists(st.lists(PARTS, max_size=4), max_size=5))
def test_parts_of_other_tracks_and_columns_harm_nothing(batches: list[list[bytes]]) -> None:
    bench = Bench()
    for number, parts in enumerate(batches):
        bench.assembler.put(batch.encode(number, number, parts))
    assert bench.assembler.next == len(batches)
    assert {place for rows in bench.rows for place in rows.columns} <= {0, 1, 2}
