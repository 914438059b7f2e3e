"""The time of a process that outsiders take."""

import time

import pytest

from fieldrig.clock import MS, US, VirtualClock
from fieldrig.loop.pace import (
    LONGEST_PAUSE_NS,
    LONGEST_WAIT_NS,
    SHARE_BESIDE_A_CYCLE,
    SLICE_BESIDE_A_CYCLE_NS,
    SLICE_NS,
    Pace,
    beside_a_cycle,
)


class Reading:
    """A reader that always has something to handle, of 100 us."""

    def __init__(self, work: "Work", pace: Pace, name: str = "", done: list[str] | None = None) -> None:
        self._work, self._pace, self._name = work, pace, name
        self.done = [] if done is None else done
        self.is_waiting = False

    def read(self) -> None:
        """Do what a reader does when there are bytes."""
        if self.is_waiting:
            return
        if self._pace.is_free(self):
            self.take_turn()
        else:
            self.is_waiting = True

    def take_turn(self) -> None:
        self.is_waiting = False
        self.done.append(self._name)
        self._work.do(self._pace, 100 * US)


class Work:
    """A clock that also counts as the time that work takes."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.clock = VirtualClock()
        monkeypatch.setattr(time, "monotonic_ns", lambda: self.clock.now_ns())

    def do(self, pace: Pace, duration_ns: int) -> None:
        began_ns = self.clock.now_ns()
        self.clock.instant_ns += duration_ns
        pace.spent(began_ns)


@pytest.fixture
def work(monkeypatch: pytest.MonkeyPatch) -> Work:
    return Work(monkeypatch)


def test_all_readers_wait_after_a_slice_until_the_timers_had_their_turn(work: Work) -> None:
    pace, done = Pace(work.clock), list[str]()
    readers = [Reading(work, pace, name, done) for name in "ab"]
    work.do(pace, SLICE_NS)
    for reader in readers:
        reader.read()
    assert done == []
    work.clock.advance_to(work.clock.now_ns())
    assert done == ["a", "b"]
    assert pace.pauses == 1


def test_who_waits_has_a_turn_each(work: Work) -> None:
    pace, done = beside_a_cycle(work.clock), list[str]()
    readers = [Reading(work, pace, name, done) for name in "abcde"]
    for _ in range(200):
        for reader in readers:
            reader.read()
        work.clock.advance_to(work.clock.now_ns() + 100 * US)
    counts = [done.count(name) for name in "abcde"]
    assert max(counts) <= 2 * min(counts) + 1, counts  # a reader that need not wait may be twice as quick


@pytest.mark.parametrize("count", [1, 30])
def test_beside_a_cycle_a_flood_gets_its_share_and_no_more(count: int, work: Work) -> None:
    pace = beside_a_cycle(work.clock)
    readers = [Reading(work, pace) for _ in range(count)]
    end_ns = 1000 * MS
    while work.clock.now_ns() < end_ns:
        for reader in readers:
            reader.read()
        work.clock.advance_to(work.clock.now_ns() + 10 * US)
    taken_ns = 100 * US * sum(len(reader.done) for reader in readers)
    assert taken_ns / end_ns == pytest.approx(SHARE_BESIDE_A_CYCLE, rel=0.1)


def test_a_client_that_asks_now_and_then_never_waits(work: Work) -> None:
    pace = beside_a_cycle(work.clock)
    reader = Reading(work, pace)
    for _ in range(1000):
        reader.read()
        assert not reader.is_waiting
        work.clock.advance_to(work.clock.now_ns() + 900 * US)
    assert pace.pauses == 0


@pytest.mark.parametrize("took_ns", [10 * MS, 1000 * MS])
def test_a_single_long_request_is_followed_by_a_pause_for_it(took_ns: int, work: Work) -> None:
    pace = beside_a_cycle(work.clock)
    reader = Reading(work, pace)
    work.do(pace, took_ns)
    reader.read()
    share_ns = round(took_ns / SHARE_BESIDE_A_CYCLE)
    until_ns = work.clock.now_ns() + min(share_ns, LONGEST_WAIT_NS)
    work.clock.advance_to(until_ns - 1)
    assert reader.is_waiting
    work.clock.advance_to(until_ns)
    assert not reader.is_waiting


def test_who_leaves_has_no_turn(work: Work) -> None:
    pace = Pace(work.clock)
    reader = Reading(work, pace)
    work.do(pace, SLICE_NS)
    reader.read()
    pace.leave(reader)
    work.clock.advance_to(work.clock.now_ns() + SLICE_NS)
    assert reader.done == []


def test_a_slice_beside_a_cycle_is_shorter_than_the_shortest_cycle() -> None:
    assert SLICE_BESIDE_A_CYCLE_NS < MS


def test_work_that_a_device_does_later_counts_once(work: Work, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "process_time_ns", work.clock.now_ns)
    pace = beside_a_cycle(work.clock)
    reader = Reading(work, pace)
    asked_ns = work.clock.now_ns()
    for _ in range(4):  # four clients have asked at once, and are answered one after the other
        work.clock.instant_ns += 100 * US
        pace.answered(asked_ns)
    assert pace.pauses == 0
    work.clock.instant_ns += 100 * US
    pace.answered(asked_ns)
    assert pace.pauses == 1
    assert not pace.is_free(reader)


def test_what_took_very_long_is_waited_for_once(work: Work) -> None:
    """A device that answers after a minute is no reason to give others four turns in 100 ms for minutes."""
    pace = beside_a_cycle(work.clock)
    done = list[str]()
    readers = [Reading(work, pace, done=done) for _ in range(20)]
    asked_ns = work.clock.now_ns()
    work.clock.instant_ns += 60_000 * MS
    pace.answered(asked_ns, has_turnaround=False)
    for _ in range(1000):
        for reader in readers:
            reader.read()
        work.clock.advance_to(work.clock.now_ns() + MS)
    assert len(done) > 500


def test_beside_a_cycle_readers_wait_while_the_whole_process_is_busy(
    work: Work, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(time, "process_time_ns", work.clock.now_ns)  # it takes a whole core
    pace = beside_a_cycle(work.clock)
    reader = Reading(work, pace)
    for _ in range(100):
        reader.read()
        work.clock.advance_to(work.clock.now_ns() + MS)
    turns = len(reader.done)
    assert 100 * MS // LONGEST_PAUSE_NS <= turns <= 20  # one now and then
    monkeypatch.setattr(time, "process_time_ns", lambda: 0)
    for _ in range(100):  # and more when it is idle again
        reader.read()
        work.clock.advance_to(work.clock.now_ns() + MS)
    assert len(reader.done) > turns + 90
