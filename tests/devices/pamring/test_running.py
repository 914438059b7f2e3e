"""A ring that runs: reports, free frames, and what stops it (section 14.4 of the digest of the system)."""

import pytest
from pamring_bench import SMART_IO, ST1, Bench

from fieldrig.clock import MS
from fieldrig_bus.ring.pam.message import Frames
from fieldrig_devices.pam.panel.codes import code_of
from fieldrig_devices.pamring.declared import DeclaredNode
from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.pamring.frames import (
    Answer,
    EndOfPipe,
    Group,
    InputChanged,
    Read,
    SetOutput,
    SetPoint,
    SetPointMode,
    Severity,
    Trouble,
)
from fieldrig_devices.pamring.settings import RingLimits
from fieldrig_devices.pamring.start_up import Phase

TWO = (DeclaredNode(1, ST1, 17), DeclaredNode(2, SMART_IO, 33))
BOTH = ((17, ST1), (33, SMART_IO))
FOUR = [(address, ST1) for address in (1, 2, 3, 4)]
VALUE = SetPoint(SetPointMode.POSITION, 1)


@pytest.fixture
def bench() -> Bench:
    return Bench(TWO, BOTH).start()


@pytest.fixture
def four() -> Bench:
    return Bench([DeclaredNode(1, ST1, 1, 4)], FOUR).start()


def faults(bench: Bench) -> list[RingFault]:
    return [node.end.fault for node in bench.nodes]


# ---- reports


def test_an_answer_is_there_two_basic_cycles_after_the_question(bench: Bench) -> None:
    bench.pam.ring.send(17, Read(5, 2))
    bench.run(2)  # it leaves with the first one
    assert bench.pam.reports == []
    bench.run(1)
    assert bench.pam.reports == [(17, Answer(5, 2))]


def test_a_report_between_cycles_comes_with_the_next_one(bench: Bench) -> None:
    bench.run(0.5)
    bench.nodes[1].end.send(InputChanged(3, 1))
    bench.run(1.5)
    assert bench.pam.reports == [(33, InputChanged(3, 1))]


@pytest.mark.manual("PAMS-105")
@pytest.mark.parametrize(
    ("severity", "code"), [(Severity.WARNING, "04..W00E"), (Severity.ENDED, "04..K00E"), (Severity.ERROR, "04..E00E")]
)
def test_trouble_of_a_node_is_shown_with_its_address_and_given_to_the_objects(severity: Severity, code: str) -> None:
    bench = Bench(TWO, BOTH).start()
    short = Trouble(severity, 0x00E, (0x10002, 5), 0)
    bench.nodes[1].end.send(short)
    bench.run(3)
    assert bench.pam.errors == [(code, (33, 0x10002, 5))]
    assert bench.pam.reports == [(33, short)]


@pytest.mark.parametrize(("code", "shown"), [(0xFFF, "FFF"), (0x1000, "000"), (0x1234, "234"), (0xFFFF, "FFF")])
def test_a_number_of_a_foreign_node_has_three_digits(bench: Bench, code: int, shown: str) -> None:
    node = bench.nodes[1].end
    node.send(Trouble(Severity.ERROR, code, (1, 2), 0))
    bench.run(3)
    report = bytes.fromhex(f"89 03 {code.to_bytes(2, 'little').hex()} 01000000 02000000 00000000")
    node._lay(bytes([len(report)]) + report)  # as a node of another maker might
    bench.run(3)
    assert bench.pam.errors == [(f"04..E{shown}", (33, 1, 2))] * 2
    assert str(code_of(bench.pam.errors[0][0])) == f"0480E{shown}"


def test_reports_of_nodes_that_are_ignored_are_dropped() -> None:
    declared = [DeclaredNode(1, ST1, 1, 2, "HEADS"), DeclaredNode(2, SMART_IO, 33, 2, "HEADS")]
    bench = Bench(declared, [(1, ST1), (2, ST1), (34, SMART_IO)]).start()
    bench.nodes[0].end.send(InputChanged(3, 1))
    bench.run(3)
    assert bench.pam.reports == []


def test_hostile_reports_are_dropped(bench: Bench) -> None:
    for garbage in (b"\x05", b"\x02\x85", b"\x01\xff", b"\0"):
        bench.nodes[0].end._lay(garbage)  # as a node of another maker might
    bench.run(3)
    assert bench.pam.reports == []
    assert bench.pam.ring.phase is Phase.RUNNING


# ---- free frames


def sent(bench: Bench) -> list[int]:
    """The number of frames of each cycle."""
    return [len(message.frames) for _, sender, message in bench.trace if sender == "pam" and hasattr(message, "frames")]


@pytest.mark.manual("PAML-167")
@pytest.mark.parametrize(("thirds", "free"), [(1, 6), (3, 20), (6, 40)])
def test_a_basic_cycle_has_twenty_free_frames_per_millisecond(thirds: int, free: int) -> None:
    settings = RingLimits(thirds=thirds)
    assert settings.frames_per_cycle == free
    assert RingLimits(thirds=thirds, frames_per_ms=1).frames_per_cycle == max(1, thirds // 3)
    bench = Bench(TWO, BOTH, settings).start()
    bench.trace.clear()
    for number in range(100):
        bench.pam.ring.send(33, SetOutput(number, 1))
    bench.run(100)
    full, rest = divmod(100, free)
    assert [count for count in sent(bench) if count] == [free] * full + [rest] * bool(rest)
    assert bench.nodes[1].orders == [SetOutput(number, 1) for number in range(100)]


@pytest.mark.manual("PAML-167")
def test_set_points_leave_with_their_cycle_and_commands_take_what_remains(four: Bench) -> None:
    for number in range(30):
        four.pam.ring.send(1, SetOutput(number, 1))
    for _ in range(15):
        four.pam.ring.send(2, VALUE)
    four.run(1.5)
    assert len(four.node(2).orders) == 15
    assert len(four.node(1).orders) == 5
    for _ in range(25):
        four.pam.ring.send(2, VALUE)
    four.run(1)
    assert len(four.node(2).orders) == 40
    assert len(four.node(1).orders) == 6, "a command always has a frame"


@pytest.mark.manual("PAML-162")
def test_a_set_point_of_a_group_is_one_frame_for_all_of_its_nodes(four: Bench) -> None:
    four.trace.clear()
    for address in (1, 3, 4):
        four.pam.ring.send(address, Group(5))
    four.pam.ring.send_to_group(5, VALUE)
    four.pam.ring.send_to_group(5, EndOfPipe(SetPointMode.POSITION))
    four.run(1.5)
    assert [node.orders for node in four.nodes] == [
        [VALUE, EndOfPipe(SetPointMode.POSITION)],
        [],
        *[four.nodes[0].orders] * 2,
    ]
    assert max(sent(four)) == 5


@pytest.mark.manual("PAMS-107", "PAML-248")
def test_too_many_commands_in_successive_cycles_fill_the_fifo_which_is_said_once() -> None:
    bench = Bench(TWO, BOTH, RingLimits(sending_fifo=50)).start()
    for _ in range(3):
        for number in range(40):
            bench.pam.ring.send(33, SetOutput(number, 1))
    assert bench.pam.errors == [("07..E006", (0, 0, 0))]
    bench.run(5)
    assert len(bench.nodes[1].orders) == 50
    for number in range(51):
        bench.pam.ring.send(33, SetOutput(number, 1))
    assert bench.pam.errors == [("07..E006", (0, 0, 0))] * 2


# ---- what stops the ring


@pytest.mark.manual("PAMS-106", "PAMS-107", "PAMS-108")
def test_a_break_names_the_node_behind_it_which_sees_no_carrier_while_the_others_see_silence(four: Bench) -> None:
    four.fault(what="break", after="n1")
    four.run(60)
    assert four.pam.errors == [("06..F010", (3, 0, 0)), ("07..E013", (0, 0, 0))]
    assert four.pam.ring.phase is Phase.FAILED
    assert faults(four) == [RingFault.INACTIVE, RingFault.INACTIVE, RingFault.CARRIER, RingFault.INACTIVE]


@pytest.mark.manual("PAMS-106")
def test_a_break_behind_the_last_node_is_noticed_by_the_pam(four: Bench) -> None:
    four.fault(what="break", after="n3")
    four.run(60)
    assert four.pam.errors[0] == ("06..F010", (0, 0, 0))
    assert faults(four) == [RingFault.INACTIVE] * 4


@pytest.mark.manual("PAMS-106")
def test_the_older_interface_finds_its_fifo_empty() -> None:
    bench = Bench(TWO, BOTH, RingLimits(interface="fpga")).start()
    bench.fault(what="break", after="n0")
    bench.run(3)
    assert bench.pam.errors == [("06..F00C", (0, 0, 0)), ("07..E013", (0, 0, 0))]


@pytest.mark.manual("PAMS-106", "PAMS-108")
def test_a_node_without_power_opens_the_ring(four: Bench) -> None:
    four.fault(what="off", station="n1")
    four.run(60)
    assert four.pam.errors[0] == ("06..F010", (3, 0, 0))
    assert four.nodes[2].end.fault is RingFault.CARRIER


@pytest.mark.manual("PAMS-106")
@pytest.mark.parametrize(("off", "behind"), [("n1", 3), ("n3", 0)])
def test_a_node_with_a_bypass_that_is_switched_off_damages_the_frame_that_the_next_one_gets(
    off: str, behind: int
) -> None:
    bench = Bench([DeclaredNode(1, ST1, 1, 4)], FOUR, bypassed=["n1", "n3"]).start()
    bench.fault(what="off", station=off)
    bench.run(3)
    assert bench.pam.errors == [("06..F00E", (behind, 0, 0)), ("07..E013", (0, 0, 0))]


def test_of_several_nodes_that_are_switched_off_at_once_the_one_behind_the_first_gets_the_damaged_frame() -> None:
    bench = Bench([DeclaredNode(1, ST1, 1, 4)], FOUR, bypassed=["n0", "n2"]).start()
    bench.fault(what="off", station="n0")
    bench.fault(what="off", station="n2")
    bench.run(3)
    assert bench.pam.errors[0] == ("06..F00E", (2, 0, 0))


def test_a_node_of_an_ignored_component_may_be_switched_off() -> None:
    declared = [DeclaredNode(1, ST1, 1, 2, "HEADS"), DeclaredNode(2, SMART_IO, 33, 2, "HEADS")]
    there = [(1, ST1), (2, ST1), (34, SMART_IO)]
    bench = Bench(declared, there, bypassed=["n0", "n1"]).start()
    assert bench.pam.ring.active == {2, 34}
    bench.fault(what="off", station="n0")
    bench.run(3)
    assert bench.pam.errors == []
    bench.fault(what="off", station="n1")
    bench.run(3)
    assert bench.pam.errors[0] == ("06..F00E", (34, 0, 0))


@pytest.mark.manual("PAMS-106", "PAMS-108")
def test_a_damaged_frame_names_the_node_behind_the_place_which_sees_a_wrong_crc(four: Bench) -> None:
    four.fault(what="distort", after="n1", count=1)
    four.run(60)
    assert four.pam.errors == [("06..F00E", (3, 0, 0)), ("07..E013", (0, 0, 0))]
    assert faults(four) == [RingFault.INACTIVE, RingFault.INACTIVE, RingFault.CRC, RingFault.INACTIVE]


@pytest.mark.manual("PAMS-106")
def test_an_oscillating_input_fills_the_reception_fifo() -> None:
    bench = Bench(TWO, BOTH, RingLimits(reports_per_ms=5, reception_fifo=20)).start()
    for _ in range(5):
        for value in range(10):
            bench.nodes[1].end.send(InputChanged(3, value & 1))
        bench.run(1)
    assert bench.pam.errors == [("06..F009", (0, 33, 0)), ("07..E013", (0, 0, 0))]
    count = len(bench.pam.reports)
    assert bench.run(10).pam.reports == bench.pam.reports[:count], "nothing is handled any longer"


def test_an_overload_by_several_nodes_is_said_once() -> None:
    bench = Bench(TWO, BOTH, RingLimits(reception_fifo=20)).start()
    for node in bench.nodes:
        for value in range(30):
            node.end.send(InputChanged(3, value & 1))
    bench.run(3)
    assert bench.pam.errors == [("06..F009", (0, 17, 0)), ("07..E013", (0, 0, 0))]


def test_orders_to_a_ring_that_has_stopped_are_lost_without_a_message(four: Bench) -> None:
    four.fault(what="break", after="n1")
    four.run(3)
    for _ in range(30):
        for number in range(100):
            four.pam.ring.send(1, SetOutput(number, 1))
        four.run(1)
    assert len(four.pam.errors) == 2


@pytest.mark.manual("PAMS-107")
def test_a_ring_that_has_stopped_is_silent_and_stays_so_when_it_is_repaired(four: Bench) -> None:
    """A node that comes back is not taken up again (G-41)."""
    number = four.fault(what="break", after="n1")
    four.run(5)
    cycles = len(sent(four))
    four.rig.clear_fault("ring0", number)
    four.run(100)
    assert len(sent(four)) == cycles
    assert len(four.pam.errors) == 2


def test_a_node_of_a_group_that_comes_later_is_not_taken_up(bench: Bench) -> None:
    heads = DeclaredNode(1, ST1, 1, 3, "HEADS")
    bench = Bench([heads], [(1, ST1), (2, ST1), (3, ST1)], bypassed=["n1"])
    number = bench.fault(what="off", station="n1")
    bench.start()
    assert bench.pam.ring.active == {1, 3}
    bench.rig.clear_fault("ring0", number)
    bench.run(10)
    bench.nodes[1].end.send(InputChanged(3, 1))
    bench.run(5)
    assert (bench.pam.errors, bench.pam.reports) == ([], [])


@pytest.mark.parametrize("thirds", [1, 3, 6])
def test_the_cycle_follows_the_basic_pam_cycle(thirds: int) -> None:
    bench = Bench(TWO, BOTH, RingLimits(thirds=thirds)).start()
    numbers = [
        message.number for _, sender, message in bench.trace if sender == "pam" and not isinstance(message, bytes)
    ]
    assert len(numbers) in (600 // thirds, 600 // thirds + 1)
    assert not any(isinstance(message, Frames) for _, _, message in bench.trace)
    assert bench.rig.statistics("ring0")["overruns"] == 0
    assert bench.nodes[0].cycles == len(numbers)
    assert bench.rig.now_ns == 200 * MS
