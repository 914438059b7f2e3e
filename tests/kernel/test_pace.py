"""What outsiders take of the time of a process."""

import time

import pytest

from fieldrig.clock import MS, US, VirtualClock
from fieldrig.pace import (
    LONGEST_PAUSE_NS,
    LONGEST_WAIT_NS,
    SHARE_BESIDE_A_CYCLE,
    SLICE_BESIDE_A_CYCLE_NS,
    SLICE_NS,
    Pace,
    beside_a_cycle,
)


class Reading:
    def __init__(self) -> None:
        self.is_waiting = False

    def wait(self, is_waiting: bool) -> None:
        self.is_waiting = is_waiting


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
    pace, readers = Pace(work.clock), [Reading(), Reading()]
    for reader in readers:
        pace.add(reader)
    work.do(pace, SLICE_NS // 2)
    assert not any(reader.is_waiting for reader in readers)
    work.do(pace, SLICE_NS // 2)
    assert all(reader.is_waiting for reader in readers)
    late = Reading()
    pace.add(late)
    assert late.is_waiting
    work.clock.advance_to(work.clock.now_ns())
    assert not any(reader.is_waiting for reader in (*readers, late))
    assert pace.pauses == 1


def test_beside_a_cycle_a_flood_gets_its_share_and_no_more(work: Work) -> None:
    pace, reader = beside_a_cycle(work.clock), Reading()
    pace.add(reader)
    taken_ns, end_ns = 0, 1000 * MS
    while work.clock.now_ns() < end_ns:
        if reader.is_waiting:
            work.clock.advance_to(min(end_ns, work.clock.next_ns() or end_ns))
        else:
            work.do(pace, 100 * US)
            taken_ns += 100 * US
    assert taken_ns / end_ns == pytest.approx(SHARE_BESIDE_A_CYCLE, rel=0.05)


def test_a_client_that_asks_now_and_then_never_waits(work: Work) -> None:
    pace, reader = beside_a_cycle(work.clock), Reading()
    pace.add(reader)
    for _ in range(1000):
        work.do(pace, 100 * US)
        work.clock.advance_to(work.clock.now_ns() + 900 * US)
    assert pace.pauses == 0


def test_a_single_long_request_is_followed_by_a_pause_for_it(work: Work) -> None:
    pace, reader = beside_a_cycle(work.clock), Reading()
    pace.add(reader)
    work.do(pace, 10 * MS)
    assert reader.is_waiting
    until_ns = work.clock.now_ns() + LONGEST_WAIT_NS
    work.clock.advance_to(until_ns - 1)
    assert reader.is_waiting
    work.clock.advance_to(until_ns)
    assert not reader.is_waiting


def test_a_slice_beside_a_cycle_is_shorter_than_the_shortest_cycle() -> None:
    assert SLICE_BESIDE_A_CYCLE_NS < MS


def test_work_that_a_device_does_later_counts_once(work: Work) -> None:
    pace, reader = beside_a_cycle(work.clock), Reading()
    pace.add(reader)
    asked_ns = work.clock.now_ns()
    for _ in range(3):  # three clients have asked at once, and are answered one after the other
        work.clock.instant_ns += 100 * US
        pace.answered(asked_ns)
    assert not reader.is_waiting
    work.clock.instant_ns += 100 * US
    pace.answered(asked_ns)
    assert reader.is_waiting


def test_beside_a_cycle_readers_wait_while_the_whole_process_is_busy(
    work: Work, monkeypatch: pytest.MonkeyPatch
) -> None:
    busy_ns = [0]
    monkeypatch.setattr(time, "process_time_ns", lambda: busy_ns[0])
    pace, reader = beside_a_cycle(work.clock), Reading()
    pace.add(reader)
    began_ns = work.clock.now_ns()
    waited = []
    for _ in range(100):
        work.clock.advance_to(work.clock.now_ns() + MS)
        busy_ns[0] += MS  # the process takes a whole core
        pace.look()
        waited.append(reader.is_waiting)
    assert any(waited)
    assert not all(waited)  # they have a slice now and then
    assert pace.pauses >= (work.clock.now_ns() - began_ns) // (2 * LONGEST_PAUSE_NS)
    for _ in range(100):  # and go on when it is idle again
        work.clock.advance_to(work.clock.now_ns() + MS)
        pace.look()
    assert not reader.is_waiting
