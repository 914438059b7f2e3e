"""Faults of a DualPort memory at the end of a device, with another program that maps the memory."""

import asyncio
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fieldrig.clock import MS, VirtualClock
from fieldrig.faults.note import FaultNote
from fieldrig.link import SharedWords
from fieldrig_bus.dualport.message import Words, decode, encode, show
from fieldrig_bus.dualport.shm import DualPortSettings, DualPortShm, SharedMemory


class At:
    """The surroundings of an end, in a run folder and on a clock that the test moves."""

    member = "pam"

    def __init__(self, run: Path) -> None:
        self.run, self.clock = run, VirtualClock()
        self.traced: list[tuple[str, Any]] = []

    def path(self, name: str) -> Path:
        return self.run / name

    def heard(self, sender: str, message: Any) -> None:
        self.traced.append((sender, message))


class Bench:
    def __init__(self, run: Path, *faults: dict[str, Any]) -> None:
        self.at = At(run)
        self._bus = DualPortShm("plc", DualPortSettings.model_validate({"faults": list(faults)}))
        self.end = asyncio.run(self._bus.open(self.at))  # type: ignore[arg-type]
        assert self.end.words is not None
        self.words: SharedWords = self.end.words
        self.plc = SharedMemory(run / "dualport/plc")

    def wait_ms(self, ms: int) -> None:
        self.at.clock.advance_to(self.at.clock.now_ns() + ms * MS)

    def close(self) -> None:
        self.plc.close()
        asyncio.run(self._bus.close("pam"))


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path)
    yield bench
    bench.close()


def test_a_stuck_word_changes_for_nobody(bench: Bench) -> None:
    bench.words[3] = 7
    number = bench.end.injected.add_fault({"what": "stuck", "word": "3", "value": "0xFFFF"})
    assert bench.plc.read(2, 3) == [0, 0xFFFF, 0]
    bench.end.send(Words(2, (1, 2, 3)))
    assert bench.plc.read(2, 3) == [1, 0xFFFF, 3]
    bench.plc.write(3, [9])
    assert bench.words[3] == 0xFFFF
    bench.end.injected.clear_fault(number)
    bench.words[3] = 2
    assert bench.plc.read(3, 1) == [2]


def test_a_word_sticks_at_its_present_value(bench: Bench) -> None:
    bench.words[3] = 7
    bench.end.injected.add_fault({"what": "stuck", "word": 3, "duration_ms": 10})
    bench.plc.write(3, [9])
    assert bench.words[3] == 7
    bench.wait_ms(10)
    assert bench.words[3] == 9


def test_a_torn_block_is_half_old_and_half_new(bench: Bench) -> None:
    bench.end.send(Words(10, (1, 1, 1, 1, 1)))
    bench.end.injected.add_fault({"what": "torn", "word": 10, "count": 4, "late_ms": 15})
    bench.end.send(Words(10, (2, 2, 2, 2, 2)))
    assert bench.plc.read(10, 5) == [2, 2, 1, 1, 2]
    bench.wait_ms(14)
    assert bench.plc.read(10, 5) == [2, 2, 1, 1, 2]
    bench.wait_ms(1)
    assert bench.plc.read(10, 5) == [2, 2, 2, 2, 2]


def test_a_newer_word_is_not_written_over_by_a_late_one(bench: Bench) -> None:
    number = bench.end.injected.add_fault({"what": "torn", "word": 10, "late_ms": 20})
    bench.words[11] = 2
    bench.wait_ms(5)
    bench.end.injected.clear_fault(number)
    assert bench.plc.read(11, 1) == [0]
    bench.words[11] = 3
    bench.wait_ms(20)
    assert bench.plc.read(11, 1) == [3]


def test_a_word_that_sticks_stays_so_when_a_late_one_comes(bench: Bench) -> None:
    bench.end.injected.add_fault({"what": "torn", "word": 10, "late_ms": 20})
    bench.words[11] = 2
    bench.end.injected.add_fault({"what": "stuck", "word": 11, "value": 9})
    bench.wait_ms(20)
    assert bench.plc.read(11, 1) == [9]


@pytest.mark.parametrize("order", [("dead", "stuck"), ("stuck", "dead")], ids=str)
def test_a_word_sticks_also_while_the_other_side_is_dead(bench: Bench, order: tuple[str, str]) -> None:
    faults: dict[str, dict[str, Any]] = {"dead": {"what": "dead"}, "stuck": {"what": "stuck", "word": 3, "value": 9}}
    for what in order:
        bench.end.injected.add_fault(faults[what])
    bench.words[3] = 5
    assert (bench.words[3], bench.plc.read(3, 1)) == (9, [9])


def test_of_two_torn_blocks_the_later_half_counts(bench: Bench) -> None:
    for late_ms in (20, 10):
        bench.end.injected.add_fault({"what": "torn", "word": 10, "late_ms": late_ms})
    bench.words[11] = 2
    bench.wait_ms(19)
    assert bench.plc.read(11, 1) == [0]
    bench.wait_ms(1)
    assert bench.plc.read(11, 1) == [2]


def test_nothing_arrives_from_a_dead_master(bench: Bench) -> None:
    bench.plc.write(0, [5, 5])
    number = bench.end.injected.add_fault({"what": "dead"})
    bench.plc.write(0, [6, 6])
    bench.words[1] = 8
    assert [bench.words[0], bench.words[1]] == [5, 8]
    assert bench.plc.read(0, 2) == [6, 8]
    bench.end.injected.clear_fault(number)
    assert [bench.words[0], bench.words[1]] == [6, 8]


def test_a_fault_is_in_the_trace_and_counted_when_it_begins(tmp_path: Path) -> None:
    bench = Bench(tmp_path, {"what": "stuck", "word": 3, "start_ms": 20})
    assert bench.at.traced == []
    assert bench.end.injected.faults()[1]["state"] == "waiting"
    bench.wait_ms(20)
    assert bench.at.traced == [("pam", FaultNote(1, "stuck"))]
    assert bench.end.injected.faults()[1]["applied"] == 1
    assert decode(encode(FaultNote(1, "stuck"))) == FaultNote(1, "stuck")
    assert show(FaultNote(1, "stuck")) == "fault 1: stuck"
    bench.close()


@pytest.mark.parametrize(
    "wrong",
    [{"what": "stuck"}, {"what": "stuck", "word": 2048}, {"what": "torn", "word": 1, "count": 1}, {"what": "drop"}],
    ids=str,
)
def test_faults_that_no_memory_has(bench: Bench, wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"word|count|no fault"):
        bench.end.injected.add_fault(wrong)
