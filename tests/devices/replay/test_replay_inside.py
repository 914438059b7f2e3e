"""The inside of a machine is compared as well: wires by value and instant, rings by the data of their drives."""

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from recorded_logs import MS, recorded, without_senders

from fieldrig import S
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.signals import traced
from fieldrig_bus.signals.signal import Signal
from fieldrig_devices.replay import replay
from fieldrig_devices.replay.align import Pair
from fieldrig_devices.replay.cycles import Cycles
from fieldrig_devices.replay.streams import Item

pytestmark = pytest.mark.long

CONFIGS = Path(__file__).parents[3] / "configs"
CONVEYOR, PAM = CONFIGS / "conveyor.yaml", CONFIGS / "pam-machine.yaml"
FEEDBACK = 17
"""The low byte of S-0-0051 of the first drive in the ATs of the conveyor: ring and AT have 10 + 2 + 5 bytes before."""
STANDING_NS = 4 * S


@pytest.fixture(scope="module")
def conveyor() -> list[TraceEntry]:
    return recorded(CONVEYOR, lambda rig: rig.run_until(4500 * MS))


@pytest.fixture(scope="module")
def pam() -> list[TraceEntry]:
    return recorded(PAM, lambda rig: rig.run_until(1500 * MS))


def is_answer(entry: TraceEntry) -> bool:
    """True if an entry has the ATs of a cycle in which all drives have cyclic data."""
    return entry.family == "ring" and entry.sender == "ring" and len(entry.data) > 60


def changed(
    log: Sequence[TraceEntry], is_meant: Callable[[TraceEntry], bool], place: int, flip: int
) -> list[TraceEntry]:
    """The log with some bits of one byte of some messages flipped."""

    def other(data: bytes) -> bytes:
        found = bytearray(data)
        found[place] ^= flip
        return bytes(found)

    return [entry._replace(data=other(entry.data)) if is_meant(entry) else entry for entry in log]


def test_a_machine_does_not_differ_from_its_own_recording(conveyor: list[TraceEntry], pam: list[TraceEntry]) -> None:
    for log, rig in ((conveyor, CONVEYOR), (pam, PAM)):
        result = replay(log, rig)
        assert result.differences == []
        inside = [entry for entry in log if entry.family in ("wires", "ring", "pamring")]
        assert result.compared >= len(inside) > 1000
        assert result.left_out == []


def test_a_value_of_a_drive_is_called_by_its_idn(conveyor: list[TraceEntry]) -> None:
    log = changed(conveyor, lambda entry: is_answer(entry) and 4 * S < entry.time_ns <= 4100 * MS, FEEDBACK, 5)
    result = replay(log, CONVEYOR)
    [found] = result.differences
    assert found.words.startswith(
        "ring sent AT with belt/S-0-0051 position feedback value 1 0 incr, the log says 5 incr"
    )
    assert found.words.endswith("(in 25 messages, by at most 5)")
    assert replay(log, CONVEYOR, value_tolerances={"S-0-0051": 5}).is_same
    assert replay(log, CONVEYOR, value_tolerances={"belt/S-0-0051": 5}).is_same
    assert not replay(log, CONVEYOR, value_tolerances={"belt/S-0-0051": 4}).is_same
    assert replay(log, CONVEYOR, leave_out=["belt"]).is_same


def test_a_bit_of_a_status_word_has_its_name(conveyor: list[TraceEntry]) -> None:
    status = 14
    log = changed(conveyor, lambda entry: is_answer(entry) and entry.time_ns > 4 * S, status, 0x20)
    [found] = replay(log, CONVEYOR).differences
    assert "belt/S-0-0135 drive status word" in found.words
    assert "bit 13, class 1 error" in found.words


def test_a_log_that_begins_in_phase_4_has_the_names_of_the_rig(conveyor: list[TraceEntry]) -> None:
    log = [entry for entry in conveyor if entry.time_ns > STANDING_NS]
    begin = log[0].time_ns
    assert replay(log, CONVEYOR, settle_ns=begin).differences == []
    [found] = replay(changed(log, is_answer, FEEDBACK, 5), CONVEYOR, settle_ns=begin).differences
    assert "belt/S-0-0051 position feedback value 1 0 incr, the log says 5 incr" in found.words


def test_missing_telegrams_are_counted_in_a_row(conveyor: list[TraceEntry]) -> None:
    log = [entry for entry in conveyor if not (is_answer(entry) and 4 * S < entry.time_ns <= 4040 * MS)]
    [found] = replay(log, CONVEYOR).differences
    assert found.words.startswith("ring sent AT ")
    assert found.words.endswith("which the log does not have (10 of them in a row)")


def test_reports_of_a_pam_have_the_names_of_their_nodes(pam: list[TraceEntry]) -> None:
    low_byte_of_status = -10

    def is_report(entry: TraceEntry) -> bool:
        return entry.family == "pamring" and entry.sender == "ring" and len(entry.data) > 100

    log = changed(pam, is_report, low_byte_of_status, 1)
    assert log != pam
    found = replay(log, PAM).differences
    assert {each.words.partition("/")[0] for each in found} == {
        "pamring sent reports with guide",
        "pamring sent reports with stacker",
    }


def wire(log: Sequence[TraceEntry], name: str, value: object) -> int:
    """The number of the first message of a wire with this value after the start."""
    return next(
        number
        for number, entry in enumerate(log)
        if entry.family == "wires" and entry.time_ns and isinstance(signal := traced.decode(entry.data), Signal)
        if (signal.name, signal.value) == (name, value)
    )


def test_a_wire_is_compared_by_value_and_instant(conveyor: list[TraceEntry]) -> None:
    number = wire(conveyor, "belt.ready", True)
    entry = conveyor[number]
    rest = [*conveyor[:number], *conveyor[number + 1 :]]
    other = entry._replace(data=traced.encode(Signal("belt.ready", False)))
    for log, expected in (
        ([*rest, entry._replace(time_ns=entry.time_ns - 35 * MS)], "belt sent belt.ready True, 35 ms later"),
        ([*rest, other], "belt set belt.ready to True, the log says False"),
        (rest, "belt sent belt.ready True, which the log does not have"),
        ([*conveyor, entry._replace(time_ns=entry.time_ns + S)], "belt did not send belt.ready True"),
    ):
        result = replay(sorted(log, key=lambda each: each.time_ns), CONVEYOR)
        assert [each.words for each in result.differences] == [expected]
        assert result.differences[0].bus == "wires"
    assert replay([*rest, entry._replace(time_ns=entry.time_ns - 15 * MS)], CONVEYOR).is_same
    assert replay(rest, CONVEYOR, leave_out=["belt.ready"]).is_same
    assert replay(rest, CONVEYOR, leave_out=["wires"]).is_same


def test_what_is_not_compared_is_named_at_the_start(conveyor: list[TraceEntry]) -> None:
    """A format that knows no senders does not name the driver of a wire; bytes of connections are never compared."""
    page = TraceEntry(S, "lan", "tcp", "browser", b"\x00GET /")
    inside = [entry for entry in without_senders(conveyor) if entry.family in ("wires", "ring")]
    outside = [entry for entry in conveyor if entry.family == "can"]
    log = sorted([*inside, *outside, page], key=lambda entry: entry.time_ns)
    result = replay(log, CONVEYOR)
    assert result.differences == []
    count = {family: sum(entry.family == family for entry in inside) for family in ("wires", "ring")}
    assert sorted(result.left_out) == sorted(
        [
            f"{count['wires']} messages of wires (wires): neither played nor compared",
            f"{count['ring']} messages of ring (ring): neither played nor compared",
            "1 message of lan (tcp): neither played nor compared",
        ]
    )


def item(time_ns: int) -> Item:
    return Item(time_ns, b"", 0, TraceEntry(time_ns, "ring", "ring", "ring", b""))


def pairs(left: Sequence[int], right: Sequence[int]) -> list[tuple[int | None, int | None]]:
    cycles = Cycles(S)
    found: list[Pair | None] = [cycles.add_left(item(time_ns)) for time_ns in left]
    found += [cycles.add_right(item(time_ns)) for time_ns in right]
    found += cycles.settle(0, is_end=True)
    assert not cycles.is_waiting
    times = [
        (None if pair.left is None else pair.left.time_ns, None if pair.right is None else pair.right.time_ns)
        for pair in found
        if pair is not None
    ]
    return sorted(times, key=lambda pair: pair[0] or pair[1] or 0)


def test_telegrams_are_paired_by_the_nearest_cycle() -> None:
    assert pairs([0, 40, 80], [1, 41, 81]) == [(0, 1), (40, 41), (80, 81)]
    assert pairs([40, 80], [1, 41, 81]) == [(None, 1), (40, 41), (80, 81)]
    assert pairs([0, 40, 80], [1, 81]) == [(0, 1), (40, None), (80, 81)]
    assert pairs([0, 40, 80], [0, 40, 80, 120]) == [(0, 0), (40, 40), (80, 80), (None, 120)]
    assert pairs([0], [2 * S]) == [(0, None), (None, 2 * S)]
