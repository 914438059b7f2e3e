"""A recording of a rig played to a fresh one: nothing differs, and what is broken is named."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recorded_logs import MS, frame, recorded, without_senders

from fieldrig import Rig, S, load, read_trace
from fieldrig.errors import ArgumentError, UsageError
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can import CanFrame
from fieldrig_bus.modbus import ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.codec import encode as modbus
from fieldrig_devices.replay import ReplayResult, diff, replay
from fieldrig_devices.replay.comparison import compare_logs

pytestmark = pytest.mark.long

CONFIGS = Path(__file__).parents[3] / "configs"
LAB, DRIVE, METER = (CONFIGS / name for name in ("lab.yaml", "drive.yaml", "energy-meter.yaml"))


def lab_master(rig: Rig) -> None:
    """A master that starts the nodes, sets outputs, and reads by expedited and segmented SDO, by TCP and RTU."""
    master = rig.attach("plc")
    can, tcp, rtu = (master.link(bus) for bus in ("can0", "mb_tcp", "mb_rtu"))
    rig.run_until(100 * MS)
    can.send(CanFrame(0, bytes.fromhex("01 00")))
    for number in range(8):
        rig.run_for(70 * MS)
        can.send(CanFrame(0x606, bytes.fromhex("40 00 10 00 00 00 00 00")))  # device type
        can.send(CanFrame(0x205, bytes((number, 0, 0, 0))))
        tcp.send(ModbusRequest(1, bytes.fromhex("04 0000 0002"), number))
        rig.run_for(60 * MS)
        tcp.send(ModbusRequest(1, bytes.fromhex("06 0000 03e8" if number % 2 else "06 0001 0001"), number))
        rtu.send(ModbusRequest(1, bytes.fromhex("03 0000 0002"), number))
        can.send(CanFrame(0x605, bytes.fromhex("40 00 20 00 00 00 00 00")))  # its place, in segments
        for toggle in ("60", "70", "60"):
            rig.run_for(10 * MS)
            can.send(CanFrame(0x605, bytes.fromhex(f"{toggle} 00 00 00 00 00 00 00")))
        can.send(CanFrame(0x605, bytes.fromhex("40 34 12 00 00 00 00 00")))  # an object that is not there
    rig.run_for(S)


def drive_master(rig: Rig) -> None:
    """A master that moves the axis by profile position, and polls statusword and position."""
    can = rig.attach("plc").link("can0")
    rig.run_for(100 * MS)
    can.send(CanFrame(0, bytes.fromhex("01 03")))

    def write(head: str, value: int, ms: int = 5) -> None:
        can.send(CanFrame(0x603, bytes.fromhex(head) + value.to_bytes(4, "little")))
        rig.run_for(ms * MS)

    write("2f 60 60 00", 1)
    for word in (6, 7, 15):
        write("2b 40 60 00", word, 60)
    for head, value in (("81", 20_000_000), ("83", 100_000_000), ("84", 100_000_000), ("7a", 5_000_000)):
        write(f"23 {head} 60 00", value)
    write("2b 40 60 00", 0x1F)
    for _ in range(60):
        write("40 41 60 00", 0, 10)
        write("40 64 60 00", 0, 10)


def meter_master(rig: Rig) -> None:
    """A master that polls three meters on TCP and on the line, and sets a ratio."""
    master = rig.attach("plc")
    for number in range(20):
        for bus in ("meters_tcp", "meters_rtu"):
            master.link(bus).send(ModbusRequest(number % 3 + 1, bytes.fromhex("04 0000 0006"), number))
            rig.run_for(90 * MS)
    master.link("meters_tcp").send(ModbusRequest(2, bytes.fromhex("06 0000 0050"), 77))
    rig.run_for(100 * MS)


@pytest.fixture(scope="module")
def lab() -> list[TraceEntry]:
    return recorded(LAB, lab_master)


@pytest.fixture(scope="module")
def drive() -> list[TraceEntry]:
    return recorded(DRIVE, drive_master)


def played(log: Sequence[TraceEntry], rig: Path, *overrides: str, play: Sequence[str] = ()) -> ReplayResult:
    return replay(log, load(rig, ("time=virtual", *overrides)), play=play)


def test_the_lab_does_not_differ_from_its_own_recording(lab: list[TraceEntry]) -> None:
    result = replay(lab, LAB)
    assert (result.differences, result.shift_ns) == ([], 0)
    assert result.played > 50
    assert result.compared > 50


def test_a_log_of_a_tool_that_knows_no_senders_is_divided_by_identifiers(lab: list[TraceEntry]) -> None:
    result = replay(without_senders(lab), LAB)
    assert result.differences == []
    assert result.played == replay(lab, LAB).played


def test_the_drive_does_not_differ_from_its_own_recording(drive: list[TraceEntry]) -> None:
    assert replay(drive, DRIVE).differences == []


def test_meters_with_values_that_live_do_not_differ_from_their_own_recording() -> None:
    log = recorded(METER, meter_master)
    result = replay(log, METER)
    assert (result.differences, result.played) == ([], 41)
    changed = played(log, METER, "seed=99")
    assert changed.differences
    assert all("answered" in each.words for each in changed.differences)


def test_what_is_played_arrives_as_it_did_in_the_log(lab: list[TraceEntry]) -> None:
    """Frames take their time on the bus, so a player that sends them when they arrived would be late."""
    again: list[TraceEntry] = []
    with Rig(load(LAB, ("time=virtual",))) as rig:
        rig.on_delivery(
            lambda bus, sent: again.append(
                TraceEntry(sent.time_ns, bus.name, bus.family, sent.sender, bus.encode(sent.message))
            )
        )
        assert replay(lab, rig).is_same
    end_ns = lab[-1].time_ns - S  # the rig goes on for as long as an answer may be late
    result = compare_logs(
        lambda: [entry for entry in lab if entry.time_ns < end_ns],
        lambda: [entry for entry in again if entry.time_ns < end_ns],
        tolerance_ns=1,
    )
    assert result.first is None


@st.composite
def masters(draw: st.DrawFn) -> list[tuple[int, str, bytes]]:
    """Messages that any master may send to the lab: SDO, PDO, NMT, SYNC, and bytes that mean nothing."""
    services = [
        b"\x40\x00\x10\x00", b"\x40\x18\x10\x01", b"\x40\x00\x20\x00", b"\x60", b"\x70", b"\x2f\x00\x62\x01\x55",
        b"\x23\x17\x10\x00\x64", b"\xa0\x00\x20\x00\x7f", b"\xa3", b"\x80\x00\x10\x00", b"\xe3\xff\xff",
    ]  # fmt: skip
    messages = []
    for _ in range(draw(st.integers(1, 25))):
        gap_ms = draw(st.integers(1, 120))
        kind = draw(st.sampled_from(["605", "606", "205", "000", "080"]))
        if kind in ("605", "606"):
            data = draw(st.sampled_from(services)).ljust(8, b"\0")
        elif kind == "000":
            data = bytes((draw(st.sampled_from([1, 2, 128, 129, 130])), draw(st.sampled_from([0, 5, 6]))))
        else:
            data = draw(st.binary(max_size=4)) if kind == "205" else b""
        messages.append((gap_ms, kind, data))
    return messages


@pytest.mark.long
@settings(max_examples=20, deadline=None)
@given(masters(), st.integers(0, 3))
def test_any_master_of_the_lab_sees_the_same_again(messages: list[tuple[int, str, bytes]], seed: int) -> None:
    def drive_it(rig: Rig) -> None:
        can = rig.attach("plc").link("can0")
        for gap_ms, identifier, data in messages:
            rig.run_for(gap_ms * MS)
            can.send(CanFrame(int(identifier, 16), data))
        rig.run_for(500 * MS)

    log = without_senders(recorded(LAB, drive_it, f"seed={seed}"))
    assert played(log, LAB, f"seed={seed}").differences == []


def words_of(result: ReplayResult) -> str:
    return "\n".join(map(str, result.differences))


BROKEN = [
    ("devices.io.objects.1017:00=500", "node 5 (io) sent a heartbeat every 500 ms, the log says 1 s"),
    ("devices.sensor.objects.1017:00=0", "node 6 (sensor) sent no heartbeat, the log has one every 1 s"),
    ("devices.tank.initial_level_m=0.6", "unit 1 (drive) answered level with 0.6 m, the log says 0.5 m (in 8 messages"),
    ("devices.tank.initial_level_m=0.6", "io sent TPDO 2 with 6401h:01 Analogue input 1 6000, the log says 5000"),
]


@pytest.mark.parametrize(("override", "words"), BROKEN)
def test_what_is_broken_is_named(lab: list[TraceEntry], override: str, words: str) -> None:
    assert words in words_of(played(lab, LAB, override))


def test_a_node_that_was_on_before_the_others_boot_owes_no_boot_up(lab: list[TraceEntry]) -> None:
    log = [each for each in lab if each.data != bytes.fromhex("05070000 01 00")]
    assert len(log) == len(lab) - 1
    result = replay(log, LAB)
    assert result.differences == []
    assert "node 5 (io) sent a boot-up, and it was on before the log began" in result.notes


def test_a_request_that_follows_an_answer_too_closely_is_not_sent_before_it() -> None:
    """A log has rounded times, so a frame may seem to have begun before the end of the one that it follows."""

    def ask(rig: Rig) -> None:
        can = rig.attach("plc").link("can0")
        for _ in range(8):
            rig.run_for(20 * MS)
            can.send(CanFrame(0x605, bytes.fromhex("40 00 10 00 00 00 00 00")))
        rig.run_for(20 * MS)

    dialogue = [each for each in recorded(LAB, ask) if each.data[:2] in (b"\x05\x06", b"\x85\x05")]
    log, now_ns = list[TraceEntry](), dialogue[0].time_ns
    for before, each in zip([dialogue[0], *dialogue], dialogue, strict=False):
        is_request = each.data[:2] == b"\x05\x06"
        now_ns += MS // 20 if is_request else each.time_ns - before.time_ns  # 50 us: no frame is as short
        log.append(each._replace(time_ns=now_ns))
    result = replay(log, LAB, leave_out=["heartbeat", "TPDO*", "wires"])
    assert result.played == 8
    assert [each for each in result.differences if "1000h" in each.words] == []


def test_a_jump_of_years_is_not_played(lab: list[TraceEntry]) -> None:
    """A row with a wrong time once let a rig run for 292 years."""
    last = next(each for each in reversed(lab) if each.family == "modbus")
    ahead, back = last._replace(time_ns=(1 << 63) - 1), last._replace(time_ns=last.time_ns + S)
    result = replay([*lab, ahead, back], LAB, leave_out=["heartbeat", "TPDO*"])
    jumps = [note for note in result.notes if "jumps" in note]
    assert [jump.split(" after ")[0].split()[-2][:9] for jump in jumps] == ["922337203", "-92233720"]
    assert result.played > 10


def test_a_bit_that_comes_later_is_named_with_its_delay(drive: list[TraceEntry]) -> None:
    """A larger inertia: the axis settles later."""
    result = played(drive, DRIVE, "devices.axis.load.inertia_kg_m2=0.2")
    [late] = [each for each in result.differences if each.subject == "6041h Statusword" and "answered" in each.words]
    assert late.words.startswith(
        "node 3 (axis) answered 6041h Statusword with 1237h, the log says 1637h: bit 10, target"
    )
    assert "reached, came 20" in late.words
    assert late.words.endswith(" ms later")


def changed(log: Sequence[TraceEntry], identifier: int, old: str, new: str) -> list[TraceEntry]:
    """The log with other data in the frames of an identifier: the rig is right, and the log is of another machine."""
    before, after = (frame(0, identifier, data).data for data in (old, new))
    assert any(entry.data == before for entry in log)
    return [
        TraceEntry(entry.time_ns, entry.bus, entry.family, entry.sender, after if entry.data == before else entry.data)
        for entry in log
    ]


def test_another_value_of_an_sdo_is_named(lab: list[TraceEntry]) -> None:
    result = replay(changed(lab, 0x586, "43 00 10 00 94 01 02 00", "43 00 10 00 95 01 02 00"), LAB)
    [only] = result.differences
    assert only.words == (
        "node 6 (sensor) answered 1000h Device type with 131476 (20194h), the log says 131477 (20195h)"
        " (in 8 messages, by at most 1)"
    )


def test_an_abort_where_the_log_has_a_value_is_named(lab: list[TraceEntry]) -> None:
    result = replay(changed(lab, 0x585, "80 34 12 00 00 00 02 06", "43 34 12 00 07 00 00 00"), LAB)
    assert len(result.differences) == 8
    assert result.differences[0].words == (
        "node 5 (io) refused the read of 1234h with 0602 0000h no object, the log says 07 00 00 00"
    )


def test_another_abort_code_is_named(lab: list[TraceEntry]) -> None:
    result = replay(changed(lab, 0x585, "80 34 12 00 00 00 02 06", "80 34 12 00 11 00 09 06"), LAB)
    assert "with 0602 0000h no object, the log says 0609 0011h" in result.differences[0].words


def test_a_transfer_that_goes_on_in_another_way_is_not_played_to_its_end(lab: list[TraceEntry]) -> None:
    """The log has the place in one message, the rig in segments: the log's next transfer is played all the same."""
    log = [frame(100, 0x605, "40 00 20 00 00 00 00 00"), frame(101, 0x585, "43 00 20 00 41 42 43 44")]
    log += [frame(150, 0x605, "40 00 10 00 00 00 00 00"), frame(151, 0x585, "43 00 10 00 91 01 0F 00")]
    result = replay(log, LAB, leave_out=["heartbeat"])
    [only] = result.differences
    assert only.words == "node 5 (io) answered the read of 2000h Location in segments, the log says ABCD"


def request(time_ms: float, number: int) -> TraceEntry:
    return frame(time_ms, 0x606, f"40 18 10 {number:02x} 00 00 00 00")


def test_a_dialogue_goes_on_when_the_answer_came_and_what_follows_is_shifted() -> None:
    """The log is of a node that answers in 20 us; the rig needs the time of a frame, and asks no earlier."""
    log = []
    for number in range(4):
        at = 100 + 0.1 * number
        log += [request(at, number + 1), frame(at + 0.02, 0x586, f"43 18 10 {number + 1:02x} 00 00 00 00")]
    heard: list[tuple[int, int]] = []
    with Rig(load(LAB, ("time=virtual",))) as rig:
        rig.on_delivery(
            lambda bus, sent: (
                heard.append((sent.time_ns, sent.message.identifier))
                if bus.name == "can0"
                and isinstance(sent.message, CanFrame)
                and sent.message.identifier in (0x606, 0x586)
                and sent.message.data[1:3] != bytes.fromhex("00 10")  # whether it has booted is asked before
                else None
            )
        )
        result = replay(log, rig)
    assert [identifier for _, identifier in heard] == [0x606, 0x586] * 4
    assert 4 * 464_000 < result.shift_ns < 4 * 1_000_000  # an answer comes 484 us after its request
    assert not [each for each in result.differences if each.subject.startswith("1018h") and "did not" in each.words]


def test_an_answer_that_never_comes_is_told_after_its_time_out() -> None:
    """The node of the rig has no power; the SYNC is sent all the same."""
    log = [frame(100, 0x606, "40 00 10 00 00 00 00 00"), frame(101, 0x586, "43 00 10 00 94 01 02 00"), frame(200, 0x80)]
    with Rig(load(LAB, ("time=virtual",))) as rig:
        rig.add_fault("sensor", {"what": "power_off"})
        result = replay(log, rig, timeout_ns=300 * MS, leave_out=["heartbeat"])
    assert words_of(result) == (
        "at 0.101 s node 6 (sensor) did not answer the read of 1000h Device type within 300 ms,"
        " the log says 131476 (20194h)"
    )
    assert result.shift_ns == 300 * MS


def test_the_log_takes_the_place_of_a_device_of_the_rig(lab: list[TraceEntry]) -> None:
    result = played(lab, LAB, play=["sensor", "master"])
    assert not [each for each in result.differences if "sensor" in each.words]
    assert any(each.node == "io" or "io" in each.node for each in result.differences) is False


def test_tolerances_and_what_is_left_out(lab: list[TraceEntry]) -> None:
    config = load(LAB, ("time=virtual", "devices.tank.initial_level_m=0.501"))
    assert not replay(lab, config).is_same
    values = {"tank.level": 0.0011, "level": 0.0011, "6401h:01": 10, "9130h:01": 1.5}
    assert replay(lab, config, value_tolerances=values).differences == []
    assert replay(lab, config, leave_out=["level", "6401h:01", "9130h:01", "wires"]).differences == []


def test_a_log_of_another_machine_is_refused(drive: list[TraceEntry]) -> None:
    with pytest.raises(UsageError) as refused:
        replay(drive, LAB)
    assert refused.value.what == "the log has nothing of the devices of lab"
    assert "does not have node 3" in refused.value.remedy


@pytest.mark.parametrize("word", ["node=200", "id=xyz", "unit=-1", "nobody", "colour=red"])
def test_a_side_that_is_not_understood_is_refused(word: str) -> None:
    with pytest.raises(UsageError) as refused:
        replay([], LAB, play=[word])
    assert f"--play {word}" in refused.value.what


def test_a_log_of_the_master_alone_is_played_and_nothing_is_compared() -> None:
    result = replay([frame(100, 0x000, "01 00"), frame(120, 0x205, "55 00 00 00")], LAB)
    assert (result.played, result.compared, result.differences) == (2, 0, [])
    assert result.notes == ["the log has no message of the rig's devices, so nothing is compared"]


EXCHANGES = [
    ("03 0100 0001", "83 02", None),
    (
        "03 0000 0001",
        "83 02",
        "read holding registers at 0 with speed_set 0 %, the log says exception 02h illegal data",
    ),
    (
        "04 0100 0001",
        "04 02 0007",
        "read input registers at 256 with exception 02h illegal data address, the log says 256",
    ),
    ("06 0000 01f4", None, "write register at 0 with data 00 00 01 F4, the log has no answer"),
]


@pytest.mark.parametrize(("request_", "response", "words"), EXCHANGES)
def test_exceptions_and_answers_that_are_not_there_are_named(
    request_: str, response: str | None, words: str | None
) -> None:
    """A capture of a network knows its clients by address, and its bus has another name."""
    begin_ns = 1_790_000_000 * S
    log = []
    level = ("04 0000 0001", "04 02 01f4")
    for number, (asked, answered) in enumerate((level, (request_, response), level)):
        at_ns = begin_ns + 100 * number * MS
        log.append(
            TraceEntry(at_ns, "eth0", "modbus", "10.0.0.5:3001", modbus(ModbusRequest(1, bytes.fromhex(asked), number)))
        )
        if answered is not None:
            data = modbus(ModbusResponse(1, bytes.fromhex(answered), number))
            log.append(TraceEntry(at_ns + 3 * MS, "eth0", "modbus", "10.0.0.9:502", data))
    result = replay(log, LAB, buses={"eth0": "mb_tcp"})
    assert result.played == 3
    assert [each.words for each in result.differences] == [] if words is None else words in words_of(result)


def test_an_answer_that_the_log_ends_before_is_no_difference() -> None:
    log = []
    for number in range(2):
        asked = ModbusRequest(1, bytes.fromhex("04 0000 0001"), number)
        log.append(TraceEntry((100 + 100 * number) * MS, "mb_tcp", "modbus", "plc", modbus(asked)))
    log.insert(1, TraceEntry(102 * MS, "mb_tcp", "modbus", "drive", modbus(ModbusResponse(1, b"\x04\x02\x01\xf4", 0))))
    result = replay(log, LAB, leave_out=["level"])
    assert (result.played, result.differences) == (2, [])


def test_a_slow_answer_that_the_log_ends_before_is_no_difference() -> None:
    """The unit takes up to 900 ms in the log, and the last request of its own comes 500 ms before the end."""
    rows = [(100, 1000), (1100, None), (1500, 1600)]  # instants of request and answer, in ms
    log = []
    for number, (asked_ms, answered_ms) in enumerate(rows):
        asked = ModbusRequest(1, bytes.fromhex("04 0000 0001"), number)
        log.append(TraceEntry(asked_ms * MS, "mb_tcp", "modbus", "plc", modbus(asked)))
        if answered_ms is not None:
            answer = modbus(ModbusResponse(1, b"\x04\x02\x01\xf4", number))
            log.append(TraceEntry(answered_ms * MS, "mb_tcp", "modbus", "drive", answer))
    assert "the log has no answer" not in words_of(replay(log, LAB, leave_out=["level"]))
    longer = [*log, frame(4000, 0x205, "55 00 00 00")]
    assert "the log has no answer" in words_of(replay(longer, LAB, leave_out=["level"]))


def test_an_emcy_that_the_rig_does_not_send_is_missed(drive: list[TraceEntry]) -> None:
    log = [*drive, frame(700, 0x083, "10 20 81 00 00 00 00 00", "axis")]
    [only] = replay(sorted(log, key=lambda entry: entry.time_ns), DRIVE).differences
    assert only.words.startswith("axis did not send EMCY error code 2010h current, error register 81h")


def test_an_empty_log_is_refused() -> None:
    with pytest.raises(UsageError, match="nothing of the devices of lab"):
        replay([], LAB)


def test_a_rig_that_runs_cannot_lose_a_device(lab: list[TraceEntry]) -> None:
    with Rig(load(LAB, ("time=virtual",))) as rig, pytest.raises(ArgumentError, match="sensor"):
        replay(lab, rig, play=["sensor"])


def test_a_recording_as_a_test_fails_with_the_first_differences(lab: list[TraceEntry]) -> None:
    replay(lab, LAB).raise_if_different()
    with pytest.raises(AssertionError, match=r"heartbeat every 500 ms"):
        played(lab, LAB, "devices.io.objects.1017:00=500").raise_if_different()


def test_a_log_with_the_time_of_day_begins_when_the_rig_has_booted(lab: list[TraceEntry]) -> None:
    """It was recorded while the machine was on, so that its boot is not in it."""
    log = [TraceEntry(each.time_ns + 1_790_000_000 * S, *_rest(each)) for each in lab if each.time_ns > 50 * MS]
    result = replay(log, LAB)
    assert {each.what.name for each in result.differences} <= {"LATE", "OTHER"}
    assert not [each for each in result.differences if "heartbeat" in each.words]


def _rest(entry: TraceEntry) -> tuple[str, str, str, bytes]:
    return entry.bus, entry.family, entry.sender, entry.data


def test_the_calls_have_files_as_well(lab: list[TraceEntry], tmp_path: Path) -> None:
    from fieldrig.traces import trace_files

    path = tmp_path / "lab.jsonl"
    trace_files.write(lab, path)
    assert diff(path, path).is_same
    assert replay(path, LAB).is_same


def test_nodes_that_run_when_the_log_begins_are_started_before(lab: list[TraceEntry]) -> None:
    """A recording of a machine seldom begins with its boot."""
    begin_ns = 1_790_000_000 * S
    log = [TraceEntry(each.time_ns + begin_ns, *_rest(each)) for each in lab if each.time_ns > 400 * MS]
    result = replay(log, LAB, leave_out=["level", "speed*", "state", "TPDO*", "RPDO*"])
    assert result.notes[0] == "the nodes 5, 6 are operational when the log begins, so they are started before"
    assert not [each for each in result.differences if "heartbeat" in each.words]


def test_a_part_of_a_recording_is_played_as_it_was(lab: list[TraceEntry], tmp_path: Path) -> None:
    """The rig runs up to there by itself, with its nodes started shortly before."""
    from fieldrig.traces import trace_files

    trace_files.write(lab, tmp_path / "lab.jsonl")
    part = read_trace(tmp_path / "lab.jsonl", 400 * MS, 1500 * MS)
    result = replay(part, LAB, leave_out=["level", "speed*", "state", "TPDO*", "RPDO*"])
    assert result.notes[0] == "the nodes 5, 6 are operational when the log begins, so they are started before"
    assert not [each for each in result.differences if "SDO" in each.words or "heartbeat" in each.words]
    assert result.played > 10
