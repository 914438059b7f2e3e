"""The short ways of `trace show` give what the long ones give: numbers in PDOs, rows of PDOs, rows of a log."""

from collections.abc import Sequence
from typing import Final

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.datatypes import DATA_TYPES
from fieldrig_devices.canopen.eds.reader import load
from fieldrig_devices.canopen.names import CanopenNames, KnownNode
from fieldrig_devices.canopen.sdo_names import number_words, typed_words
from fieldrig_devices.cia402.single.own_objects import EDS
from fieldrig_devices.named_logs.can_rows import CanRows
from fieldrig_devices.named_logs.named_log import NamedLog
from fieldrig_devices.named_logs.row import Row
from fieldrig_devices.named_logs.rows import Rows

NODE = 3
INTEGERS: Final = [0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x15, 0x1B, 0x10, 0x16]
"""Signed and unsigned numbers (CiA 301, table 44), of 24 bits too."""
SDO_READ, SDO_VALUE = bytes.fromhex("40 41 60 00 00 00 00 00"), bytes.fromhex("4B 41 60 00 37 06 00 00")
IDENTIFIERS = (0x000, 0x080, 0x083, 0x183, 0x203, 0x283, 0x383, 0x403, 0x583, 0x603, 0x703, 0x123, 0x7E5)


def plain(row: Row) -> tuple[object, ...]:
    """Everything in a row, and not what `details` is but what it returns."""
    return (row.time_ns, row.bus, row.sender, row.services, row.words, row.entries, row.end_ns, row.data,
            row.node_ids, row.identifiers, row.unit, dict(row.details()))  # fmt: skip


@given(st.sampled_from(INTEGERS), st.integers(0, 2**64 - 1))
def test_a_number_is_in_the_same_words(code: int, bits: int) -> None:
    variable = load(EDS, NODE).by_key("6041:00")
    type_ = DATA_TYPES[code]
    assert type_.size is not None
    variable.type = type_
    words = number_words(variable, 8 * type_.size)
    assert words is not None
    number = bits & (1 << 8 * type_.size) - 1
    assert words(number) == typed_words(variable, number.to_bytes(type_.size, "little"))


@pytest.mark.parametrize("code", [0x01, 0x08, 0x09])
def test_other_types_have_the_long_way(code: int) -> None:
    variable = load(EDS, NODE).by_key("6041:00")
    assert number_words(variable, 12) is None  # a part of it
    variable.type = DATA_TYPES[code]
    assert number_words(variable, 16) is None
    assert number_words(None, 16) is None


frames = st.builds(
    lambda identifier, data, is_remote: CanFrame(identifier, b"" if is_remote else data, is_remote=is_remote),
    st.sampled_from(IDENTIFIERS),
    st.one_of(st.binary(max_size=8), st.sampled_from([SDO_READ, SDO_VALUE, b"\x05", b"\x7f", b"\x00"])),
    st.booleans(),
)


@given(st.lists(frames, max_size=30))
def test_a_pdo_has_the_same_row(messages: list[CanFrame]) -> None:
    short, long = (CanRows(CanopenNames({NODE: KnownNode("axis", load(EDS, NODE))})) for _ in range(2))
    for number, message in enumerate(messages):
        entry = TraceEntry(number * MS, "can0", "can", "axis", encode(message))
        assert plain(short.row(number, entry)) == plain(long.any_row(number, entry))


class LongWay(Rows):
    """Rows without the way for PDOs that nothing waits for."""

    def _alone(self, number: int, entry: TraceEntry) -> Row | None:
        return None


def rows_of(kind: type[Rows], log: Sequence[TraceEntry], every_frame: bool) -> list[tuple[object, ...]]:
    return [plain(row) for row in kind(NamedLog({NODE: EDS}), every_frame=every_frame).of(log)]


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 3_000), st.booleans(), frames), max_size=40), st.booleans())
def test_a_log_has_the_same_rows(messages: list[tuple[int, bool, CanFrame]], every_frame: bool) -> None:
    """The logs have transfers that are open for a while, heartbeats that stay out, and two buses."""
    log, now_ns = [], 0
    for gap_ms, is_second, message in messages:
        now_ns += gap_ms * MS
        log.append(TraceEntry(now_ns, "can1" if is_second else "can0", "can", "", encode(message)))
    assert rows_of(Rows, log, every_frame) == rows_of(LongWay, log, every_frame)
