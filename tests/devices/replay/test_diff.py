"""Two logs compared, over every kind of difference."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from recorded_logs import MS, frame

from fieldrig import load
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import encode as modbus
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.signals import traced
from fieldrig_bus.wires import Motion
from fieldrig_devices.named_logs.named_log import NamedLog
from fieldrig_devices.replay.comparison import compare_logs
from fieldrig_devices.replay.diff_result import DiffResult
from fieldrig_devices.replay.leave_out import LeftOut
from fieldrig_devices.replay.log_names import LogNames

ROOT = Path(__file__).parents[3]
Log = Sequence[TraceEntry]


def compared(left: Log, right: Log, rig: str = "", leave_out: Sequence[str] = ()) -> DiffResult:
    config = load(ROOT / "configs" / rig, ("time=virtual",)) if rig else None
    named = NamedLog(config=config)
    names = (LogNames(named), LogNames(named))
    return compare_logs(lambda: left, lambda: right, leave_out=LeftOut(leave_out), names=names)


def later(log: Log, by_ms: float) -> list[TraceEntry]:
    return [TraceEntry(entry.time_ns + round(by_ms * MS), entry.bus, entry.family, "", entry.data) for entry in log]


@st.composite
def logs(draw: st.DrawFn) -> list[TraceEntry]:
    """A log of some identifiers, periodic ones and others, with contents that repeat or not."""
    count = draw(st.integers(2, 60))
    gaps = draw(st.lists(st.integers(1, 40), min_size=count, max_size=count))
    identifiers = draw(st.lists(st.sampled_from([0x181, 0x182, 0x705]), min_size=count, max_size=count))
    contents = draw(st.lists(st.sampled_from(["00", "01", "FF", "AA55"]), min_size=count, max_size=count))
    at, log = 0, []
    for gap, identifier, content in zip(gaps, identifiers, contents, strict=True):
        at += gap
        log.append(frame(at, identifier, content))
    return log


@given(logs(), st.sampled_from([0, 3_000, 1_700_000_000_000]))
def test_a_log_does_not_differ_from_itself_whenever_it_began(log: list[TraceEntry], by_ms: int) -> None:
    result = compared(log, later(log, by_ms))
    assert (result.is_same, result.first) == (True, None)


@given(logs(), st.data())
def test_any_deleted_frame_is_found(log: list[TraceEntry], data: st.DataObject) -> None:
    place = data.draw(st.integers(0, len(log) - 1))
    result = compared(log, [*log[:place], *log[place + 1 :]])
    assert not result.is_same
    assert sum(row.left - row.right for row in result.rows) == 1


@given(logs(), st.data())
def test_any_changed_frame_is_found(log: list[TraceEntry], data: st.DataObject) -> None:
    place = data.draw(st.integers(0, len(log) - 1))
    old = log[place]
    new = TraceEntry(old.time_ns, old.bus, old.family, "", old.data[:-1] + bytes((old.data[-1] ^ 0x40,)))
    result = compared(log, [*log[:place], new, *log[place + 1 :]])
    assert not result.is_same
    assert result.first is not None
    assert result.first.time_ns <= old.time_ns


@given(logs(), st.data(), st.integers(60, 900))
def test_any_moved_frame_is_found(log: list[TraceEntry], data: st.DataObject, by_ms: int) -> None:
    """It has data of its own: in a row of frames that are all the same, a moved one is only jitter of the others."""
    place = data.draw(st.integers(0, len(log) - 1))
    log = [*log[:place], frame(log[place].time_ns / MS, 0x181, "1234"), *log[place + 1 :]]
    moved = [*log[:place], *later([log[place]], by_ms), *log[place + 1 :]]
    moved.sort(key=lambda entry: entry.time_ns)
    assert not compared(log, moved).is_same


def test_the_first_difference_is_shown_with_what_was_around_it_on_both_sides() -> None:
    log = [frame(10 * number, 0x181, f"{number:02X}") for number in range(30)]
    result = compared(log, [*log[:20], *log[21:]])
    assert result.first is not None
    assert (result.first.time_ns, result.first.what) == (200 * MS, "missing in the second log")
    assert [(each.time_ns // MS, each.is_it) for each in result.first.around_left] == [
        (160, False), (170, False), (180, False), (190, False), (200, True),
        (210, False), (220, False), (230, False), (240, False),
    ]  # fmt: skip
    assert [each.time_ns // MS for each in result.first.around_right] == [160, 170, 180, 190, 210, 220, 230, 240, 250]


def test_values_that_differ_have_names_and_bits() -> None:
    """The IO node's RPDO 1 writes its outputs, and its heartbeat has a state."""
    left = [frame(0, 0x705, "05"), frame(10, 0x205, "07000000")]
    right = [frame(0, 0x705, "7F"), frame(10, 0x205, "37000000")]
    words = {row.stream: (row.node, row.kind, row.words) for row in compared(left, right, "lab.yaml").rows}
    assert words["705"] == ("io", "heartbeat", "state operational, then pre-operational")
    assert words["205"] == ("io", "RPDO 1", "6200h:01 Write outputs byte 1 7, then 55 (37h)")


def test_bits_of_a_statusword_have_the_names_of_cia_402() -> None:
    left, right = [frame(0, 0x183, "3706")], [frame(0, 0x183, "3702")]
    [row] = compared(left, right, "drive.yaml").rows
    assert row.words == "6041h Statusword 0637h, then 0237h (bit 10, target reached)"


def test_registers_have_the_names_of_their_table_by_the_request() -> None:
    def exchange(at: int, value: int) -> list[TraceEntry]:
        request, response = bytes.fromhex("04 0000 0001"), bytes((4, 2, *value.to_bytes(2)))
        return [
            TraceEntry(at * MS, "mb_tcp", "modbus", "tcp:1", modbus(ModbusRequest(1, request, at))),
            TraceEntry(at * MS, "mb_tcp", "modbus", "drive", modbus(ModbusResponse(1, response, at))),
        ]

    result = compared([*exchange(0, 7), *exchange(10, 7)], [*exchange(0, 7), *exchange(10, 9)], "lab.yaml")
    [row] = [row for row in result.rows if not row.is_same]
    assert (row.stream, row.node, row.words) == ("unit 1 response", "drive", "level 0.007 m, then 0.009 m")


def test_one_bus_of_a_family_is_the_same_bus_whatever_its_name() -> None:
    log = [frame(10 * number, 0x181, f"{number:02X}") for number in range(9)]
    other = [TraceEntry(entry.time_ns, "vcan3", "can", "", entry.data) for entry in log]
    result = compared(log, other)
    assert result.is_same
    assert result.notes == ["can0 of the first log is compared with vcan3 of the second"]


def test_logs_of_different_machines_are_told_as_such() -> None:
    result = compared([frame(0, 0x181, "01")], [frame(0, 0x282, "01")])
    assert (result.is_same, len(result.notes)) == (False, 1)
    assert "no stream in common" in result.notes[0]


@pytest.mark.parametrize("pattern", ["705", "0x705", "705h", "can0/705", "7*"])
def test_what_is_left_out_is_not_compared(pattern: str) -> None:
    left = [frame(0, 0x181, "01"), frame(5, 0x705, "05")]
    assert compared(left, left[:1], leave_out=[pattern]).is_same
    assert not compared(left, left[:1], leave_out=["706"]).is_same


def test_bytes_of_a_serial_line_are_compared_as_telegrams_not_as_chunks() -> None:
    def chunk(at: float, data: str, sender: str = "card") -> TraceEntry:
        return TraceEntry(round(at * MS), "user", "serial", sender, b"\x00" + data.encode())

    whole = [chunk(0, "READ?", "pc"), chunk(20, "1.25 mm\r")]
    pieces = [chunk(0, "REA", "pc"), chunk(1, "D?", "pc"), chunk(20, "1.25"), chunk(22, " mm\r")]
    assert compared(whole, pieces).is_same
    assert not compared(whole, [*pieces[:3], chunk(22, " cm\r")]).is_same


def test_a_frame_that_is_missing_long_ago_is_one_difference() -> None:
    """Frames with the same data in eight streams of 8 ms: nothing but the gap says which one is missing."""

    def log(left_out: int | None = None) -> list[TraceEntry]:
        frames = [frame(0, 0x181 + number, "05").data for number in range(8)]
        return [
            TraceEntry(number * MS, "can0", "can", "", frames[number % 8])
            for number in range(10_000)
            if number != left_out
        ]

    [row] = [row for row in compared(log(), log(5_432)).rows if not row.is_same]
    assert (row.missing, row.more, row.other, row.later, row.earlier) == (1, 0, 0, 0, 0)


def test_clients_have_other_numbers_in_other_logs() -> None:
    def chunk(sender: str) -> TraceEntry:
        return TraceEntry(0, "user", "serial", sender, b"\x00READ?")

    assert compared([chunk("tcp:1")], [chunk("tcp:3")]).is_same


def test_a_wire_that_moves_is_the_same_whenever_its_log_began() -> None:
    """The signal has the instant of its position, by the clock of its log."""

    def moved(at_ms: int) -> TraceEntry:
        motion = Motion("axis.position", 1.5, "rad", time_ns=at_ms * MS, speed=2.0)
        return TraceEntry(at_ms * MS, "wires", "wires", "axis", traced.encode(motion))

    result = compared([moved(100)], [moved(5_100)])
    assert (result.is_same, result.offset_ns) == (True, 5_000 * MS)
