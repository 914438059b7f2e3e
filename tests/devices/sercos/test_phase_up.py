"""A ring brought up, telegram by telegram; and what brings it down again."""

import itertools
from itertools import pairwise
from typing import Any

import pytest
from ring_bench import RingBench

from fieldrig.clock import MS
from fieldrig_bus.ring.sercos.message import Answers, Cycle, Mdt, Mst
from fieldrig_devices.sercos import words
from fieldrig_devices.sercos.idn import Element, ServiceError
from fieldrig_devices.sercos.ring_drive import Event

UP_MS = 2_000


def telegrams(bench: RingBench, phase: int) -> list[str]:
    """MDTs and ATs of a phase in their order, in hex."""
    lines = []
    for _, _, message in bench.trace:
        if isinstance(message, Cycle) and message.mst == bytes((0xFF, phase)) and message.mdt:
            lines.append("MDT " + message.mdt.hex(" "))
        elif isinstance(message, Answers):
            lines += ["AT " + at.hex(" ") for at in message.ats]
    return lines


def test_cp0_is_ten_master_sync_telegrams_that_come_round() -> None:
    bench = RingBench(5).up(4, ms=15)
    begun = [message for _, _, message in bench.trace if isinstance(message, Cycle)]
    assert [cycle.mst.hex() for cycle in begun[:10]] == ["ff00"] * 10
    assert {cycle.mdt for cycle in begun[:10]} == {b""}
    assert begun[10].mst.hex() == "ff01"


@pytest.mark.long
def test_cp1_calls_each_drive_by_its_address() -> None:
    bench = RingBench(5, 9).up(1)
    # status 4000h: ready for power
    assert (
        telegrams(bench, 1)[:6]
        == [
            "MDT 05 00 00 00 00",
            "AT 05 00 40 00 00",
            "MDT 09 00 00 00 00",
            "AT 09 00 40 00 00",
        ][:6]
    )
    assert bench.master.phase == 1


@pytest.mark.long
def test_cp2_reads_what_the_drive_needs_over_the_service_channel() -> None:
    bench = RingBench(5).up(2)
    lines = telegrams(bench, 2)
    start = lines.index("MDT 05 0f 00 03 00")
    # S-0-0003: IDN; attribute 7011 0001h (never written, unsigned, two bytes, factor 1); 10 us.  Then S-0-0004
    assert lines[start : start + 10] == [
        "MDT 05 0f 00 03 00",
        "AT 05 01 40 00 00",
        "MDT 05 18 00 00 00",
        "AT 05 00 40 01 00",
        "MDT 05 1d 00 00 00",
        "AT 05 01 40 11 70",
        "MDT 05 3c 00 00 00",
        "AT 05 00 40 0a 00",
        "MDT 05 0f 00 04 00",
        "AT 05 01 40 00 00",
    ]


@pytest.mark.long
def test_cp2_writes_the_timing_and_lets_the_drive_check_it() -> None:
    bench = RingBench(5).up(2)
    table = bench.drives[5].table
    assert [table[number].number for number in (1, 2, 9, 10, 15)] == [4000, 4000, 1, 8, 7]
    assert (table[24].numbers, table[16].numbers) == ([47], [51])
    # MST 54 bits, AT of 9 bytes 88 bits and 17 stuffed and 16, MDT of 9 bytes the same, at 4 MBaud with gaps of 10 us
    # all counted from the end of the MST
    assert table[6].number == 10
    assert table[89].number == 50  # + 30.25 + 10
    assert table[8].number == 180  # + 30.25 + 100
    lines = telegrams(bench, 2)
    start = lines.index("MDT 05 0f 00 7f 00") if "MDT 05 0f 00 7f 00" in lines else lines.index("MDT 05 0e 00 7f 00")
    assert any("MDT 05 3e 00 03 00" in line or "MDT 05 3f 00 03 00" in line for line in lines[start:])
    assert table[127].status == 0  # done, and cleared


def test_cp4_carries_command_values_and_feedback() -> None:
    bench = RingBench(5, 9).up()
    bench.master.set_commands(5, 0xE000, 1_000_000)
    bench.master.set_commands(9, 0xE000, -2)
    bench.trace.clear()
    bench.run(12)
    # MDT: FF, then control word, service channel, S-0-0047 of each drive; AT: status word 8000h, S-0-0051
    # (3Eh and 1 are what the service channel's last steps left behind)
    mdts = [bytes.fromhex(line[4:]) for line in telegrams(bench, 4) if line.startswith("MDT")]
    assert {(mdt[:1] + mdt[2:3] + mdt[5:9] + mdt[10:11] + mdt[13:]).hex(" ") for mdt in mdts[1:]} == {
        "ff e0 40 42 0f 00 e0 fe ff ff ff"
    }
    assert bench.master.drives[5].feedback == (1_000_000,)
    assert bench.master.drives[9].feedback == (-2,)
    assert bench.master.drives[5].status & 0xC000 == 0x8000


@pytest.mark.long
@pytest.mark.manual("PD-133")
@pytest.mark.parametrize("cycle_ms", [1, 2, 4])
def test_the_cycle_is_1_2_or_4_ms(cycle_ms: int) -> None:
    bench = RingBench(3, 1, cycle_ms=cycle_ms).up()
    assert bench.master.phase == 4
    bench.trace.clear()
    bench.run(40)
    times = [when_ns for when_ns, _, message in bench.trace if isinstance(message, Cycle)]
    assert {after - before for before, after in pairwise(times)} == {cycle_ms * MS}


@pytest.mark.long
@pytest.mark.manual("PD-132")
def test_command_values_are_sent_in_every_cycle_and_all_states_come_back() -> None:
    bench = RingBench(3, 1).up()
    numbers, came_back = itertools.count(1_000), dict[int, list[tuple[int, ...]]]({1: [], 3: []})

    def on_cycle() -> None:
        number = next(numbers)
        for address, drive in bench.master.drives.items():
            came_back[address].append(drive.feedback)
            bench.master.set_commands(address, 0, number * address)

    bench.master._on_cycle = on_cycle
    bench.run(400)
    for address, drive in bench.drives.items():
        given = [(number * address,) for number in range(1_000, 1_100)]
        assert drive.commands[-100:] in (given, [(0,), *given[:-1]])
        assert came_back[address][-90:] in [given[10 - lag : 100 - lag] for lag in (1, 2, 3)]


@pytest.mark.manual("PD-137")
def test_a_parameter_takes_some_cycles() -> None:
    bench = RingBench(3).up()
    got: list[tuple[int, Any]] = []
    begin_ns = bench.rig.now_ns
    bench.master.read(3, 104, Element.DATA, lambda outcome: got.append((bench.controller.clock.now_ns(), outcome)))
    bench.run(200)
    (when_ns, data), *_ = got
    assert data == b"\x64\0"
    assert 4 * 4 * MS <= when_ns - begin_ns <= 7 * 4 * MS


@pytest.mark.long
def test_telegrams_that_do_not_fit_into_the_cycle_keep_the_ring_down() -> None:
    bench = RingBench(*range(1, 41), cycle_ms=1).up()
    assert [event.code for event in bench.seen(Event.NO_ROOM)] == [bench.master.needed_ns() // 1000]
    assert bench.master.needed_ns() > 1 * MS
    assert bench.master.phase == 0


@pytest.mark.long
def test_a_drive_that_is_not_there_is_named() -> None:
    bench = RingBench(3, 1)
    bench.drives[1].node.link("ring0").on_receive(lambda _message: None, [["drive", 77]])
    bench.up()
    assert [event.address for event in bench.seen(Event.MISSING)] == [1]
    assert bench.master.phase == 0


@pytest.mark.long
def test_two_drives_of_one_address_do_not_come_up() -> None:
    bench = RingBench(3)
    bench.drives[3].node.link("ring0").on_receive(lambda _message: None, [["drive", 3], ["drive", 3]])
    bench.up()
    assert bench.seen(Event.MISSING)
    assert bench.master.wrong_fcs > 0 or bench.master.phase == 0


@pytest.mark.long
def test_a_drive_that_finds_its_operation_data_wrong_keeps_the_ring_down() -> None:
    bench = RingBench(3, 1)
    bench.drives[1].invalid = [47]
    bench.up()
    assert [(event.address, event.idn) for event in bench.seen(Event.REFUSED)] == [(1, 128)]
    assert bench.drives[1].table[22].numbers == [47]
    assert bench.master.phase == 0


@pytest.mark.long
def test_timing_that_can_not_be_is_found_in_cp2() -> None:
    bench = RingBench(3)
    table = bench.drives[3].table
    table[3].set(5_000)  # the drive needs longer than a cycle before its AT
    bench.up()
    assert bench.seen(Event.REFUSED)[0].address == 3
    assert 6 in table[21].numbers
    assert bench.master.phase == 0


# ---- failures


def failing(bench: RingBench, ms: float = 40, **fault: Any) -> RingBench:
    bench.events.clear()
    bench.rig.add_fault("ring0", fault)
    return bench.run(ms)


@pytest.mark.parametrize("telegram", ["mst", "mdt", "at"])
def test_one_telegram_may_be_missing(telegram: str) -> None:
    bench = failing(RingBench(3, 1).up(), what="distort", station="drive1", telegram=telegram, count=1)
    assert bench.master.phase == 4
    assert bench.drives[1].slave.phase == 4
    assert bench.drives[1].missed == (telegram != "at")
    counters = bench.drives[1].table[28].number, bench.drives[1].table[29].number
    assert counters == {"mst": (1, 0), "mdt": (0, 1), "at": (0, 0)}[telegram]
    lost = [(event.address, event.code) for event in bench.seen(Event.AT_FAILED)]
    assert lost == ([] if telegram == "mdt" else [(1, 1)])


@pytest.mark.parametrize(("telegram", "status"), [("mst", 0x0008), ("mdt", 0x0010)])
def test_two_of_the_masters_in_a_row_bring_the_drive_down(telegram: str, status: int) -> None:
    bench = failing(RingBench(3, 1).up(), what="distort", station="drive1", telegram=telegram, count=2)
    drive = bench.drives[1]
    assert (drive.slave.failures, drive.failures) == (status, 1)
    assert drive.slave.phase == 0
    assert bench.master.phase == 0  # for its ATs are missing


def test_ats_may_be_missing_again_and_again_but_not_in_a_row() -> None:
    bench = RingBench(3, 1).up()
    for count in range(1, 6):
        failing(bench, what="distort", station="drive1", telegram="at", count=1)
        assert [(event.address, event.code) for event in bench.seen(Event.AT_FAILED)] == [(1, 1)]
        assert (bench.master.phase, bench.master.drives[1].lost) == (4, count)


def test_two_ats_in_a_row_bring_the_ring_down() -> None:
    bench = failing(RingBench(3, 1).up(), what="distort", station="drive1", telegram="at", count=2)
    assert [(event.address, event.code) for event in bench.seen(Event.AT_FAILED)] == [(1, 1), (1, 2)]
    assert bench.master.phase == 0
    assert bench.drives[3].phases[-1] == 0


@pytest.mark.long
@pytest.mark.manual("PD-140")
def test_a_break_brings_all_drives_down_and_a_healed_ring_comes_up_again() -> None:
    bench = failing(RingBench(3, 1, 2).up(), what="break", after="drive0", duration_ms=100)
    assert bench.events[0].what is Event.OPEN
    assert bench.master.phase == 0
    assert [drive.slave.phase for drive in bench.drives.values()] == [0, 0, 0]
    assert [drive.failures for drive in bench.drives.values()] == [0, 1, 1]  # before the break MSTs go on
    bench.run(100)
    assert bench.events[-1].what is Event.CLOSED
    bench.master.request_phase(4)
    assert bench.run(UP_MS).master.phase == 4


@pytest.mark.long
@pytest.mark.parametrize("cycle_ms", [1, 2, 4])
@pytest.mark.parametrize("phase", [3, 4])
def test_a_silent_master_is_noticed_when_two_msts_are_missing(cycle_ms: int, phase: int) -> None:
    """The drive itself detects it half a cycle after the second one was due, because no chip reports anything."""
    bench = RingBench(3, cycle_ms=cycle_ms).up(phase, 3_000 + 0.9 * cycle_ms)
    heard_ns = bench.trace[-1][0]
    assert isinstance(bench.trace[-1][2], Cycle)
    bench.master.stop()
    noticed_ns = heard_ns + cycle_ms * MS * 5 // 2
    bench.rig.run_until(noticed_ns - 1)
    assert (bench.drives[3].slave.phase, bench.drives[3].failures) == (phase, 0)
    bench.rig.run_until(noticed_ns)
    assert (bench.drives[3].slave.phase, bench.drives[3].failures) == (0, 1)
    assert bench.drives[3].slave.failures == 0x0018  # S-0-0014: MST and MDT
    bench.run(100)
    assert bench.drives[3].failures == 1, "once"


@pytest.mark.parametrize("late_ms", [1, 4, 7, 9])
def test_a_master_that_is_late_by_less_is_not_missed(late_ms: int) -> None:
    bench = RingBench(3).up(ms=3_003.6)
    bench.master.stop()
    bench.run(late_ms)
    bench.controller.link("ring0").send(Mst(0, b"\xff\x04"))
    bench.controller.link("ring0").send(Mdt(b""))
    assert bench.run(2).drives[3].slave.phase == 4


@pytest.mark.long
def test_no_master_is_missed_before_cp3() -> None:
    bench = RingBench(3).up(2)
    bench.master.stop()
    assert bench.run(1_000).drives[3].slave.failures == 0


def test_a_wrong_phase_is_refused() -> None:
    bench = RingBench(3).up()
    bench.master.phase = 2
    bench.run(10)
    assert bench.drives[3].slave.failures & 0x0080
    bench.drives[3].slave.clear_failures()
    assert bench.drives[3].slave.failures == 0


@pytest.mark.long
def test_a_request_on_a_ring_that_goes_down_is_answered() -> None:
    bench = RingBench(3).up()
    got: list[bytes | ServiceError] = []
    bench.master.read(3, 30, Element.DATA, got.append)
    bench.run(6)
    bench.master.request_phase(0)
    assert [str(error) for error in got] == ["service channel error 0003h"]


@pytest.mark.long
def test_same_seed_same_telegrams() -> None:
    runs = [RingBench(3, 1) for _ in range(2)]
    fault = {"what": "distort", "station": "drive0", "telegram": "at", "probability": 0.01}
    for run in runs:
        run.up(ms=1).rig.add_fault("ring0", fault)
        run.run(3_000)
    assert runs[0].trace == runs[1].trace
    assert runs[0].master.wrong_fcs > 0
    assert any(isinstance(message, Mdt | Cycle) for _, _, message in runs[0].trace)


def test_answer_of_a_wrong_length_is_none() -> None:
    bench = RingBench(3, 1).up()
    bench.drives[1].on_cycle = lambda values: (words.POWERED, b"")  # type: ignore[method-assign]
    bench.events.clear()
    bench.run(40)
    assert [(event.address, event.code) for event in bench.seen(Event.AT_FAILED)] == [(1, 1), (1, 2)]
    assert bench.master.phase == 0
