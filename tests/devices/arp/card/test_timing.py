"""Control loop, scheduler and slices (digest 11; manual 2.2)."""

import pytest
from arp_bench import CardBench

from fieldrig.clock import MS, VirtualClock
from fieldrig_devices.arp.card_access import CardState

COUNT = "LOOP:\nV1 += 1\nGOTO LOOP"


class LateClock(VirtualClock):
    """A clock on a host that is busy at times."""

    late = 0

    def late_ns(self) -> int:
        late, self.late = self.late, 0
        return late


class StalledClock(VirtualClock):
    """Block, and then call everything that was due meanwhile, as a real clock does after a long stall."""

    resumes_ns = 0

    def now_ns(self) -> int:
        return max(super().now_ns(), self.resumes_ns)


@pytest.mark.manual("ARP-007")
@pytest.mark.parametrize("period_ms", range(1, 11))
def test_the_control_loop_has_the_period_of_par_1(period_ms: int) -> None:
    bench = CardBench(COUNT, {"general": {1: period_ms}}).run_for(1_000)
    assert bench.get("cycles") == 1_000 // period_ms


@pytest.mark.manual("ARP-007")
def test_a_longer_control_period_makes_the_program_faster() -> None:
    counts = [CardBench(COUNT, {"general": {1: ms}}).run_for(2_010).variable(1) for ms in (1, 2, 5, 10)]
    assert counts == sorted(counts)
    # 50 us per instruction, two in a turn; 300 us per loop, and 100 us per ms for the scheduler, every 10 ms
    assert counts[0] == pytest.approx(2_000 * (1_000 - 300 - 100) / 100, rel=0.01)
    assert counts[3] == pytest.approx(200 * (10_000 - 300 - 1_000) / 100, rel=0.01)


@pytest.mark.manual("ARP-016")
def test_a_longer_scheduler_period_makes_the_program_faster() -> None:
    fast, slow = (CardBench(COUNT, {"general": {16: ms}}).run_for(2_000 + ms).variable(1) for ms in (100, 10))
    assert fast == pytest.approx(2_000 * (1_000 - 300 - 10) / 100, rel=0.01)
    assert slow < fast


def test_costs_are_settings() -> None:
    bench = CardBench(COUNT, costs={"instruction_us": 10, "control_us": 0, "scheduler_us": 0}).run_for(1_010)
    assert bench.variable(1) == pytest.approx(50_000, rel=0.01)


def test_a_loop_that_comes_late_skips_and_counts_what_it_missed() -> None:
    clock = LateClock()
    bench = CardBench(COUNT, {"general": {1: 2}}, clock=clock).run_for(20)
    assert (bench.get("cycles"), bench.get("missed_cycles")) == (10, 0)
    clock.late = 7 * MS  # for the loop at 22 ms, which runs at 29
    bench.run_for(2)
    assert (bench.get("cycles"), bench.get("missed_cycles")) == (11, 3)
    bench.run_for(7.9)
    assert bench.get("cycles") == 11  # 24, 26 and 28 ms have passed
    bench.run_for(0.1)
    assert (bench.get("cycles"), bench.get("missed_cycles")) == (12, 3)
    clock.late = 2 * MS - 1
    bench.run_for(2)
    assert bench.get("missed_cycles") == 3  # less than a whole period


def test_a_stall_is_counted_though_the_clock_takes_up_from_the_present() -> None:
    clock = StalledClock()
    bench = CardBench(COUNT, clock=clock).run_for(20)
    clock.resumes_ns = 70 * MS
    bench.run_for(0)
    assert (bench.get("cycles"), bench.get("missed_cycles")) == (21, 49)
    bench.run_for(10)
    assert (bench.get("cycles"), bench.get("missed_cycles")) == (31, 49)


@pytest.mark.manual("ARP-004")
def test_a_program_without_end_starves_no_other_part() -> None:
    bench = CardBench("LOOP:\nGOTO LOOP", {"axis1": {4: 1}}).run_for(1_000)
    assert (bench.state, bench.get("cycles")) == (CardState.RUN, 1_000)


@pytest.mark.manual("ARP-109")
def test_a11_a_timer_sets_its_flag_after_5_s() -> None:
    bench = CardBench("SET F1\nSTIM 1, 5, F1\nSET F2\nLOOP:\nGOTO LOOP").run_for(11)
    assert (bench.access.F[1], bench.access.F[2]) == (0, 1)
    bench.run_for(4_998)  # it was started at 10 ms
    assert not bench.access.F[1]
    bench.run_for(1)
    assert bench.access.F[1]


@pytest.mark.manual("ARP-108", "ARP-110")
def test_a12_polling_a_timer_for_a_second() -> None:
    bench = CardBench("STIM 1\nLINEA:\nV1 == TIM 1\nIF V1 < 1, LINEA\nSET O101").run_for(1_009)
    assert bench.last_sent("O101") is False
    bench.run_for(2)
    assert (bench.last_sent("O101"), bench.variable(1)) == (True, 1.0)


@pytest.mark.manual("ARP-107")
def test_wait_holds_the_program_and_nothing_else() -> None:
    bench = CardBench("PAC 1, 1000\nWAIT 0.5\nSET O101\nLOOP:\nGOTO LOOP", {"axis1": {4: 1, 7: 1_000}}).run_for(509)
    assert bench.last_sent("O101") is False
    assert bench.position(1) == pytest.approx(494, abs=2)
    assert bench.run_for(2).last_sent("O101") is True
