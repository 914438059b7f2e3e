"""When the rows of a process in real time are taken, on a host that is late."""

import asyncio
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

from in_loop import in_loop

from fieldrig.clock import MS, VirtualClock
from fieldrig.loop.real_clock import RealClock
from fieldrig.real.recorded import ProcessSource


class HandClock(VirtualClock):
    """A clock by hand whose events nothing announces."""

    before_event: Callable[[int], None] | None = None

    def look_at(self, instant_ns: int, read: Callable[..., Any], *arguments: Any) -> Any:
        return read(*arguments)


def source_of(clock: HandClock) -> ProcessSource:
    return ProcessSource(cast(Any, SimpleNamespace(clock=clock)))


@in_loop
async def test_of_cycles_within_one_event_the_last_one_is_a_row() -> None:
    clock = HandClock()
    source = source_of(clock)
    one, two = list[tuple[int, int]](), list[tuple[int, int]]()

    def take_one(now_ns: int, missed: int) -> None:
        one.append((now_ns, missed))

    def take_two(now_ns: int, missed: int) -> None:
        two.append((now_ns, missed))

    for instant_ns in (1, 2, 3):
        clock.instant_ns = instant_ns
        source.after_cycle(take_one)
    source.after_cycle(take_two)
    assert source.now_ns() == 1, "later rows may still come"
    assert not one
    await asyncio.sleep(0)
    assert (one, two) == ([(3, 2)], [(3, 0)])
    assert source.now_ns() == 3
    clock.instant_ns = 4
    source.after_cycle(take_one)
    await asyncio.sleep(0)
    assert one[1:] == [(4, 0)]


@in_loop
async def test_values_are_looked_at_once_after_events_that_are_handled_together() -> None:
    clock = HandClock()
    source, looks = source_of(clock), list[str]()

    def one() -> None:
        looks.append("one")

    def two() -> None:
        looks.append("two")

    ends = [source.watch(one), source.watch(two)]
    on_event = cast(Any, clock).on_event
    for _ in range(3):
        on_event()
    await asyncio.sleep(0)
    assert looks == ["one", "two"]
    ends[0]()
    on_event()
    await asyncio.sleep(0)
    assert looks == ["one", "two", "two"]
    ends[1]()
    assert cast(Any, clock).on_event is None


@in_loop
async def test_cycles_by_timers_that_are_handled_together_are_all_rows() -> None:
    clock = RealClock(asyncio.get_running_loop())
    source, rows, counted = source_of(cast(Any, clock)), list[tuple[int, int, int]](), 0
    ended = asyncio.Event()
    begin_ns = clock.now_ns() - 8 * MS

    def take(now_ns: int, missed: int) -> None:
        rows.append(((now_ns - begin_ns) // MS, missed, counted))

    def cycle() -> None:
        nonlocal counted
        counted += 1
        source.after_cycle(take)
        if counted == 5:
            ended.set()

    for number in range(5):
        clock.call_at(begin_ns + number * MS, cycle)
    await ended.wait()
    await asyncio.sleep(0)
    clock.close()
    assert [(missed, count) for _, missed, count in rows] == [(0, 1), (0, 2), (0, 3), (0, 4), (0, 5)]
    assert clock.after_timer is None
