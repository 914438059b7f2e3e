"""A log that begins in the middle of operation, against a rig that begins with its power: what boots is waited for."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from recorded_logs import MS, frame, recorded, without_senders

from fieldrig import Rig, S, load
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can import CanFrame
from fieldrig_bus.modbus import ModbusRequest
from fieldrig_devices.replay import ReplayResult, replay

pytestmark = pytest.mark.long

CONFIGS = Path(__file__).parents[3] / "configs"
DRIVE, METER, LAB = (CONFIGS / name for name in ("drive.yaml", "energy-meter.yaml", "lab.yaml"))
BOOTED_NS = 9 * S
SLOW = ("time=virtual", "buses.can0.bitrate=10000")
TODAY_NS = 1_700_000_000 * S


def polling(rig: Rig) -> None:
    """A master of a drive that has run for a while: it polls status word and position."""
    can = rig.attach("plc").link("can0")
    rig.run_for(8 * S)
    can.send(CanFrame(0, bytes.fromhex("01 03")))
    can.send(CanFrame(0x603, bytes.fromhex("40 00 10 00 00 00 00 00")))
    rig.run_until(BOOTED_NS)
    for _ in range(20):
        for head in ("40 41 60", "40 64 60"):
            can.send(CanFrame(0x603, bytes.fromhex(head).ljust(8, b"\0")))
            rig.run_for(100 * MS)


def middle(personality: str) -> list[TraceEntry]:
    """The log of a foreign tool that was started late."""
    log = without_senders(recorded(DRIVE, polling, f"devices.axis.personality={personality}"))
    return [entry for entry in log if entry.time_ns >= BOOTED_NS]


def moved(log: Sequence[TraceEntry], by_ns: int) -> list[TraceEntry]:
    return [entry._replace(time_ns=entry.time_ns + by_ns) for entry in log]


def played(log: Sequence[TraceEntry], personality: str, settle_ns: int | None = None) -> ReplayResult:
    rig = load(DRIVE, ("time=virtual", f"devices.axis.personality={personality}"))
    return replay(log, rig, settle_ns=settle_ns)


@pytest.mark.parametrize(
    ("personality", "is_late"),
    [("robot-joint", True), ("mains-inverter", True), ("own-units", True), ("runs-ahead", False)],
)
def test_a_drive_that_boots_is_waited_for_whatever_the_clock_of_the_log(personality: str, is_late: bool) -> None:
    """They boot for 2 s, 3 s, 1 s and not at all; the first one loses the first SDO after its boot."""
    log = middle(personality)
    for each in (moved(log, -BOOTED_NS), moved(log, TODAY_NS)):
        result = played(each, personality)
        assert result.differences == []
        assert result.played > 30
        held = [note for note in result.notes if note.startswith("the log was held back for ")]
        assert all(note.endswith("until node 3 (axis) had booted") for note in held)
        assert len(held) == is_late


def test_a_drive_whose_first_sdo_is_lost_in_the_log_loses_it_in_the_rig_too() -> None:
    """A question before the log would be the first one."""

    def polling_late(rig: Rig) -> None:
        can = rig.attach("plc").link("can0")
        rig.run_until(BOOTED_NS)
        for _ in range(6):
            can.send(CanFrame(0x603, bytes.fromhex("40 41 60 00 00 00 00 00")))
            rig.run_for(S)

    beat = frame(9_000.001, 0x703, "7f")
    log = [beat, *without_senders(recorded(DRIVE, polling_late, "devices.axis.personality=robot-joint"))]
    log = moved([entry for entry in log if entry.time_ns >= BOOTED_NS], TODAY_NS)
    rig = load(DRIVE, ("time=virtual", "devices.axis.personality=robot-joint"))
    result = replay(log, rig, leave_out=["heartbeat"])
    assert result.differences == []
    assert result.played == 6


def test_a_log_that_is_played_at_once_finds_a_drive_that_boots() -> None:
    result = played(moved(middle("robot-joint"), TODAY_NS), "robot-joint", settle_ns=0)
    assert "did not answer the read of 6041h Statusword" in result.differences[0].words


def test_settle_is_the_least_time_and_a_longer_one_holds_nothing_back() -> None:
    log = moved(middle("robot-joint"), TODAY_NS)
    for settle_ns, is_held in ((S, True), (5 * S, False)):
        result = played(log, "robot-joint", settle_ns)
        assert result.differences == []
        assert any("held back" in note for note in result.notes) is is_held


def test_a_node_that_boots_in_the_log_is_not_waited_for() -> None:
    """The log begins at power-on, and its master asks in vain before the drive has booted."""

    def hasty(rig: Rig) -> None:
        can = rig.attach("plc").link("can0")
        for _ in range(6):
            can.send(CanFrame(0x603, bytes.fromhex("40 41 60 00 00 00 00 00")))
            rig.run_for(S)

    name = "mains-inverter"
    log = without_senders(recorded(DRIVE, hasty, f"devices.axis.personality={name}"))
    for each in (log, moved(log, TODAY_NS)):
        result = played(each, name)
        assert result.differences == []
        assert not any("held back" in note for note in result.notes)


def test_a_log_in_which_other_nodes_boot_waits_for_no_longer_than_a_boot_up() -> None:
    """The rig begins with the log, as its values count from there; a question would take the time of an answer."""
    log = [frame(at, 0x705, "05") for at in range(0, 5000, 1000)] + [frame(20, 0x706, "00")]
    log += [frame(700, 0x605, "40 00 10 00 00 00 00 00"), frame(700.5, 0x585, "43 00 10 00 91 01 0F 00")]
    result = replay(moved(sorted(log), TODAY_NS), load(LAB, ("time=virtual",)))
    assert not any("held back" in note for note in result.notes)
    assert "held back" in str(replay(moved(sorted(log), TODAY_NS), load(LAB, SLOW)).notes)


def test_a_node_that_never_comes_is_told_and_missed() -> None:
    log = [frame(at, 0x703, "05") for at in range(0, 5000, 1000)] + [frame(2500, 0x603, "40 00 10 00 00 00 00 00")]
    rig = load(DRIVE, ("time=virtual", "devices.axis.behaviour={boot_up_ms: 600000}"))
    result = replay(sorted(log), rig)
    assert "node 3 (axis) sent nothing in 60 s, so the log began without it" in result.notes
    assert [each.words for each in result.differences] == ["node 3 (axis) sent no heartbeat, the log has one every 1 s"]


def test_a_unit_that_does_not_answer_yet_is_asked_again() -> None:
    def ask(rig: Rig) -> None:
        link = rig.attach("plc").link("meters_tcp")
        for number in range(8):
            link.send(ModbusRequest(2, bytes.fromhex("03 0000 0001"), number))
            rig.run_for(90 * MS)

    log = without_senders(recorded(METER, ask))
    boots = "buses.meters_tcp.faults=[{what: drop, of: request, unit: 2, duration_ms: 3500}]"
    result = replay(log, load(METER, ("time=virtual", boots)))
    assert result.differences == []
    assert result.notes == ["unit 2 answered after 4.002 s, in which it was asked again"]
    at_once = replay(log, load(METER, ("time=virtual", boots)), settle_ns=0)
    assert "did not answer" in at_once.differences[0].words
