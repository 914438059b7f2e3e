"""Rows of logs: the bytes are those of CiA 301's pictures of the protocols and of the Modbus application protocol."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from canopen_bench import EDS, IO32
from hypothesis import given, settings
from hypothesis import strategies as st
from logs import can_entry, can_log, modbus_log

from fieldrig.clock import MS, S
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import LineState, ModbusRequest, ModbusResponse
from fieldrig_devices.named_logs.named_log import NamedLog
from fieldrig_devices.named_logs.row import Row
from fieldrig_devices.named_logs.rows import Rows

TABLE = EDS.parent / "registers" / "pump-drive.yaml"
PLAIN = NamedLog()


@pytest.fixture(scope="module")
def named() -> NamedLog:
    return NamedLog({5: IO32}, {1: TABLE})


def rows_of(entries: Sequence[TraceEntry], names: NamedLog = PLAIN, *, every_frame: bool = False) -> list[Row]:
    return list(Rows(names, every_frame=every_frame).of(entries))


def words(*frames: str, names: NamedLog = PLAIN) -> list[str]:
    return [row.words for row in rows_of(can_log(*frames), names)]


@pytest.mark.parametrize(
    ("frames", "text"),
    [
        (("605#40 00 10 00 00 00 00 00", "585#43 00 10 00 91 01 0F 00"),
         "SDO read node 5 1000:00 Device type = 983441 (F0191h), in 1 ms"),
        (("605#2F 00 62 01 0F 00 00 00", "585#60 00 62 01 00 00 00 00"),
         "SDO write node 5 6200:01 Write outputs byte 1 = 15 (Fh), in 1 ms"),
        (("605#40 08 10 00 00 00 00 00", "585#41 08 10 00 09 00 00 00", "605#60 00 00 00 00 00 00 00",
          "585#00 31 32 33 34 35 36 37", "605#70 00 00 00 00 00 00 00", "585#1B 38 39 00 00 00 00 00"),
         "SDO read node 5 1008:00 Manufacturer device name = 123456789, 9 bytes in segments in 5 ms"),
        (("605#A4 08 10 00 7F 00 00 00", "585#C6 08 10 00 09 00 00 00", "605#A3 00 00 00 00 00 00 00",
          "585#01 31 32 33 34 35 36 37", "585#82 38 39 00 00 00 00 00", "605#A2 02 7F 00 00 00 00 00",
          "585#D5 C3 31 00 00 00 00 00", "605#A1 00 00 00 00 00 00 00"),
         "SDO read node 5 1008:00 Manufacturer device name = 123456789, 9 bytes in blocks in 7 ms"),
        (("605#40 00 63 00 00 00 00 00", "585#80 00 63 00 00 00 02 06"),
         "SDO read node 5 6300:00: aborted by the node, 0602 0000h no object, in 1 ms"),
        (("605#40 00 10 00 00 00 00 00", "605#80 00 10 00 00 00 04 05"),
         "SDO read node 5 1000:00 Device type: aborted by the client, 0504 0000h protocol timed out, in 1 ms"),
        (("605#40 00 10 00 00 00 00 00",),
         "SDO read node 5 1000:00 Device type: no answer (the log ends before)"),
        (("605#40 00 1A 01 00 00 00 00", "585#43 00 1A 01 10 01 01 64"),
         "SDO read node 5 1A00:01 Mapped object 1 = 6401:01, 16 bits, in 1 ms"),
        (("605#40 00 18 01 00 00 00 00", "585#43 00 18 01 85 01 00 C0"),
         "SDO read node 5 1800:01 COB-ID used by TPDO = 185h, no remote requests, not valid, in 1 ms"),
        (("000#01 05",), "NMT node 5 start"),
        (("085#30 81 11 00 00 00 00 00",),
         "EMCY node 5 8130h life guard or heartbeat error, register 11h (generic communication)"),
        (("123#01 02",), "123 [2] 01 02"),
    ],
)  # fmt: skip
def test_a_dialogue_is_one_row_in_words(named: NamedLog, frames: tuple[str, ...], text: str) -> None:
    (row,) = rows_of(can_log(*frames), named)
    assert row.words == text
    assert row.entries == tuple(range(len(frames)))
    assert len(rows_of(can_log(*frames), named, every_frame=True)) == len(frames)


def test_a_node_without_eds_has_the_names_that_every_node_has() -> None:
    assert words("606#40 17 10 00 00 00 00 00", "586#4B 17 10 00 64 00 00 00") == [
        "SDO read node 6 1017:00 Producer heartbeat time = 100 (64h), in 1 ms"
    ]


def test_a_drive_without_eds_has_the_names_of_its_profile() -> None:
    """Device type 0002 0192h: profile 402, which the log shows before the objects of the profile."""
    asked = ("606#40 41 60 00 00 00 00 00", "586#4B 41 60 00 37 02 00 00")
    before, _, after = words(*asked, "606#40 00 10 00 00 00 00 00", "586#43 00 10 00 92 01 02 00", *asked)
    assert before == "SDO read node 6 6041:00 = 37 02 (567), in 1 ms"
    assert after.lower() == "sdo read node 6 6041:00 statusword = 567 (237h, operation enabled), in 1 ms"


@pytest.mark.parametrize(
    ("asked", "answer", "text"),
    [
        ("40 01 64 02", "4B 01 64 02 9C FF 00 00", "6401:02 Read analogue input 16-bit, 2 = -100"),
        ("40 00 60 00", "4F 00 60 00 04 00 00 00", "6000:00 Read input 8-bit, number of entries = 4"),
        ("40 26 63 01", "43 26 63 01 FF 00 00 00", "6326:01 Error mode output 32-bit, 1 = 255"),
        ("40 23 64 00", "4F 23 64 00 01 00 00 00", "6423:00 Analogue input global interrupt enable = True"),
    ],
)
def test_an_i_o_module_without_eds_has_the_names_of_its_profile(asked: str, answer: str, text: str) -> None:
    """Device type 000F 0191h: profile 401."""
    asking = (f"606#{asked} 00 00 00 00", f"586#{answer}")
    before, _, after = words(*asking, "606#40 00 10 00 00 00 00 00", "586#43 00 10 00 91 01 0F 00", *asking)
    assert text not in before
    assert after.startswith(f"SDO read node 6 {text}")


def test_a_pdo_has_the_fields_of_its_eds_until_the_log_shows_another_mapping(named: NamedLog) -> None:
    mapped = (
        "605#2F 00 1A 00 00 00 00 00", "585#60 00 1A 00 00 00 00 00",
        "605#23 00 1A 01 10 01 01 64", "585#60 00 1A 01 00 00 00 00",
        "605#2F 00 1A 00 01 00 00 00", "585#60 00 1A 00 00 00 00 00",
    )  # fmt: skip
    before, *_, after = words("185#01 02 03 04", *mapped, "185#18 FC", names=named)
    assert before == "TPDO 1 node 5 " + ", ".join(f"Read inputs byte {number} {number}" for number in range(1, 5))
    assert after == "TPDO 1 node 5 Analogue input 1 -1000"


def test_a_log_that_begins_in_the_middle_is_read_on() -> None:
    found = words("585#00 31 32 33 34 35 36 37", "605#70 00 00 00 00 00 00 00", "705#05")
    assert found[0].endswith("(an answer without its request)")
    assert found[1].endswith("(a request without the beginning of its transfer)")
    assert found[2] == "heartbeat node 5 operational"


def beats(*ms: int, node: int = 5) -> list[TraceEntry]:
    return [can_entry(at * MS, CanFrame(0x700 + node, b"\x05")) for at in ms]


def lost(entries: list[TraceEntry]) -> list[tuple[int, str]]:
    found = rows_of(sorted(entries, key=lambda entry: entry.time_ns))
    return [(row.time_ns // MS, row.words) for row in found if "loss" in row.services]


def test_a_heartbeat_that_stays_out_is_missing_after_twice_its_own_period() -> None:
    entries = beats(0, 100, 200, 300, 400, 1000) + beats(*range(0, 2000, 100), node=6)
    assert lost(entries) == [
        (600, "heartbeat missing node 5 since 0.400000 s, expected every 100 ms"),
        (1000, "heartbeat back node 5 after 600 ms"),
        (1200, "heartbeat missing node 5 since 1.000000 s, expected every 100 ms"),
    ]


def test_the_period_is_that_of_1017h_if_the_log_shows_it() -> None:
    read = [
        can_entry(0, CanFrame(0x605, bytes.fromhex("40 17 10 00 00 00 00 00"))),
        can_entry(0, CanFrame(0x585, bytes.fromhex("4B 17 10 00 32 00 00 00"))),
    ]
    assert lost(read + beats(1000, node=6)) == [
        (100, "heartbeat missing node 5 since 0.000000 s, expected every 50 ms")
    ]


def test_a_heartbeat_that_is_switched_off_is_not_missing() -> None:
    off = [
        can_entry(450 * MS, CanFrame(0x605, bytes.fromhex("2B 17 10 00 00 00 00 00"))),
        can_entry(451 * MS, CanFrame(0x585, bytes.fromhex("60 17 10 00 00 00 00 00"))),
    ]
    assert lost(beats(0, 100, 200, 300, 400) + off + beats(5000, node=6)) == []


def test_answers_to_guarding_are_no_heartbeat() -> None:
    guarded = [can_entry(at * MS, CanFrame(0x705, is_remote=True)) for at in range(0, 500, 100)]
    assert lost(guarded + beats(1, 101, 201, 301, 401) + beats(9000, node=6)) == []


def test_guarding_without_an_answer_is_told_once_and_its_end_too() -> None:
    requests = [can_entry(at * MS, CanFrame(0x705, is_remote=True)) for at in range(0, 600, 100)]
    assert lost(requests + beats(1, 101, 401, 501)) == [
        (300, "guarding unanswered node 5 since the request of 0.200000 s"),
        (401, "guarding back node 5 after 300 ms"),
    ]


READ, VALUES = bytes.fromhex("04 00 00 00 02"), bytes.fromhex("04 04 01 F4 01 C2")


@pytest.mark.parametrize(
    ("unit", "request_", "response", "text"),
    [
        (1, READ, VALUES, "read input registers unit 1 level 0.5 m, speed 45 %, in 1 ms"),
        (2, READ, VALUES, "read input registers unit 2 0-1 = 01F4h 01C2h, in 1 ms"),
        (1, READ, b"\x84\x02", "read input registers unit 1 level, speed: exception 02h illegal data address, in 1 ms"),
        (1, READ, None, "read input registers unit 1 level, speed: no answer (the log ends before the answer)"),
        (1, bytes.fromhex("06 00 00 01 F4"), bytes.fromhex("06 00 00 01 F4"),
         "write register unit 1 speed_set 50 %, in 1 ms"),
        (2, bytes.fromhex("06 00 00 01 F4"), bytes.fromhex("06 00 00 01 F4"),
         "write register unit 2 0 = 01F4h, in 1 ms"),
        (2, bytes.fromhex("10 00 01 00 02 04 00 0A 01 02"), bytes.fromhex("10 00 01 00 02"),
         "write registers unit 2 1-2 = 000Ah 0102h, in 1 ms"),
        (2, bytes.fromhex("05 00 AC FF 00"), bytes.fromhex("05 00 AC FF 00"), "write coil unit 2 172 = on, in 1 ms"),
        (2, bytes.fromhex("17 00 03 00 02 00 0E 00 01 02 00 FF"), bytes.fromhex("17 04 00 FE 0A CD"),
         "read/write registers unit 2 3-4, write 14 = 00FFh: 00FEh 0ACDh, in 1 ms"),
        (2, b"\x07", b"\x07\x6d", "read exception status unit 2 6Dh, in 1 ms"),
    ],
)  # fmt: skip
def test_a_modbus_request_and_its_answer_are_one_row(
    named: NamedLog, unit: int, request_: bytes, response: bytes | None, text: str
) -> None:
    answers = [] if response is None else [("drive", ModbusResponse(unit, response))]
    (row,) = rows_of(modbus_log([("a", ModbusRequest(unit, request_)), *answers]), named)
    assert row.words == text


def test_a_broadcast_says_so() -> None:
    broadcast = ModbusRequest(0, bytes.fromhex("06 00 00 01 F4"), 0, LineState())
    (row,) = rows_of(modbus_log([("a", broadcast)]))
    assert row.words == "write register unit 0 0 = 01F4h, to all units"


def test_rows_are_in_the_order_of_their_first_messages() -> None:
    found = words("605#40 00 10 00 00 00 00 00", "080#", "585#43 00 10 00 91 01 0F 00")
    assert [text.split()[0] for text in found] == ["SDO", "SYNC"]


def test_an_answer_that_comes_very_late_has_another_row() -> None:
    asked, answered = can_log("605#40 00 10 00 00 00 00 00", "585#43 00 10 00 91 01 0F 00")
    between = can_log("080#")[0]
    entries = [
        TraceEntry(at_ns, entry.bus, entry.family, entry.sender, entry.data)
        for at_ns, entry in ((0, asked), (S, between), (12 * S, between), (20 * S, answered))
    ]
    assert [row.words for row in rows_of(entries)] == [
        "SDO read node 5 1000:00 Device type (still open)",
        "SYNC",
        "SYNC",
        "SDO read node 5 1000:00 Device type = 983441 (F0191h), in 20 s",
    ]
    assert len(rows_of(entries[:-1])) == 3


frames = st.builds(
    CanFrame,
    st.sampled_from([0x000, 0x080, 0x085, 0x185, 0x205, 0x585, 0x605, 0x705, 0x7E5, 0x123]),
    st.binary(max_size=8),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(frames, max_size=40))
def test_each_message_of_any_log_is_in_exactly_one_row(named: NamedLog, sent: list[CanFrame]) -> None:
    entries = [can_entry(number * MS, frame) for number, frame in enumerate(sent)]
    for every_frame in (False, True):
        numbers = [number for row in rows_of(entries, named, every_frame=every_frame) for number in row.entries]
        assert sorted(numbers) == list(range(len(sent)))


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(["can", "modbus", "wires", "ring", "serial", "unheard"]), st.binary(max_size=20))
def test_any_bytes_of_any_family_have_a_row(family: str, data: bytes) -> None:
    (row,) = rows_of([TraceEntry(0, "bus", family, "", data)])
    assert row.as_data()["data"] == data.hex()


def test_the_names_of_a_rig_are_used_where_it_has_the_bus(tmp_path: Path) -> None:
    from fieldrig.config.rig_file import load

    config = load(EDS.parent / "lab.yaml")
    (row,) = rows_of(can_log("705#05"), NamedLog(config=config))
    assert row.words == "heartbeat io operational"
