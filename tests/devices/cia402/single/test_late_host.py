"""A host that stands still for a while, as in real time: the motor goes on as if every cycle had come in time."""

from collections.abc import Callable

import pytest
from single_drive_bench import SingleDriveBench

from fieldrig.clock import MS, Timer, VirtualClock

POSITION, VELOCITY = 1, 3


class LateClock(VirtualClock):
    """A clock whose events come all the later, the longer the host has stood still."""

    __slots__ = ("stood_ns",)

    def __init__(self) -> None:
        super().__init__()
        self.stood_ns = 0

    def now_ns(self) -> int:
        return self.instant_ns + self.stood_ns

    def call_at(self, when_ns: int, action: Callable[[], None]) -> Timer:
        return super().call_at(when_ns - self.stood_ns, action)

    def advance_to(self, until_ns: int) -> int:
        return super().advance_to(until_ns - self.stood_ns)


def late_and_prompt() -> tuple[LateClock, list[SingleDriveBench]]:
    clock = LateClock()
    return clock, [SingleDriveBench(clock=clock), SingleDriveBench()]


@pytest.mark.parametrize("late_ms", [1, 2, 30, 200])
def test_the_speed_has_no_step(late_ms: int) -> None:
    clock, benches = late_and_prompt()
    for bench in benches:
        bench.enabled(VELOCITY).put(0x60FF, 1_000_000).after(500)
    late, prompt = benches
    clock.stood_ns = late_ms * MS
    late.after(1)
    prompt.after(1 + late_ms)
    assert late.get(0x606C) == prompt.get(0x606C) == pytest.approx(1_000_000, rel=0.01)
    assert late.get(0x6064) == prompt.get(0x6064)


def test_a_move_ends_where_it_should() -> None:
    clock, benches = late_and_prompt()
    for bench in benches:
        bench.enabled(POSITION).put(0x607A, 1_000_000).control(0x1F)
    late, prompt = benches
    for _ in range(20):
        late.after(10)
        clock.stood_ns += 15 * MS
    late.after(1)
    prompt.after(501)
    assert late.get(0x6064) == prompt.get(0x6064)


def test_a_host_that_is_always_late_does_not_fall_behind_for_good() -> None:
    """Beyond half a second the cycles are skipped, and the motor waits for its next set value."""
    clock = LateClock()
    bench = SingleDriveBench(clock=clock).enabled(VELOCITY)
    bench.put(0x60FF, 1_000_000).after(500)
    speeds: list[int] = []
    for _ in range(3):
        clock.stood_ns += 400 * MS
        bench.after(1)
        speeds.append(bench.get(0x606C))
    assert speeds[0] == pytest.approx(1_000_000, rel=0.01)
    assert speeds[2] < 900_000
