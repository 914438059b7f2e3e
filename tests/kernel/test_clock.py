import asyncio
import time
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, NEVER_NS, Alarm, S, TimerQueue, VirtualClock
from fieldrig.loop.real_clock import STALL_NS, RealClock


def test_virtual_time_stands_still_until_it_is_moved() -> None:
    clock = VirtualClock()
    called: list[int] = []
    clock.call_at(5, lambda: called.append(clock.now_ns()))
    assert clock.now_ns() == 0
    clock.advance_to(4)
    assert called == []
    clock.advance_to(10)
    assert called == [5]
    assert clock.now_ns() == 10


def test_equal_times_are_called_in_order_of_asking() -> None:
    clock = VirtualClock()
    called: list[str] = []
    for name in "abc":
        clock.call_at(7, lambda name=name: called.append(name))  # type: ignore[misc]  # a default keeps the loop's value
    clock.advance_to(7)
    assert called == ["a", "b", "c"]


def test_what_is_past_is_called_at_the_present() -> None:
    clock = VirtualClock(100)
    called: list[int] = []
    clock.call_at(50, lambda: called.append(clock.now_ns()))
    clock.advance_to(100)
    assert called == [100]


def test_a_cancelled_timer_is_not_called_and_is_no_next_event() -> None:
    clock = VirtualClock()
    timer = clock.call_at(5, lambda: pytest.fail("cancelled"))
    timer.cancel()
    timer.cancel()
    assert clock.next_ns() is None
    clock.advance_to(10)


def test_a_watchdog_that_is_put_off_is_not_called_and_then_once() -> None:
    clock = VirtualClock()
    called: list[int] = []
    watchdog = clock.watch(lambda: called.append(clock.now_ns()))
    assert clock.next_ns() is None
    for now_ns in range(0, 1_000, 10):
        clock.advance_to(now_ns)
        watchdog.due_ns = now_ns + 25
        assert clock.next_ns() == now_ns + 25
    assert clock.advance_to(1_014) == 1_015
    assert clock.advance_to(5_000) == NEVER_NS
    assert (called, clock.now_ns(), clock.next_ns()) == ([1_015], 5_000, None)


def test_a_watchdog_beyond_never_is_no_next_event() -> None:
    clock = VirtualClock(10)
    clock.watch(lambda: pytest.fail("never")).due_ns = NEVER_NS + 10
    assert (clock.next_ns(), clock.advance_to(S)) == (None, NEVER_NS)


@given(st.lists(st.tuples(st.booleans(), st.integers(0, 50)), max_size=30))
def test_watchdogs_and_timers_are_called_in_the_order_of_their_instants(asked: list[tuple[bool, int]]) -> None:
    """Timers go first at the same instant."""
    clock = VirtualClock()
    called: list[tuple[int, bool]] = []
    for is_watchdog, when_ns in asked:
        action = partial(lambda is_watchdog: called.append((clock.now_ns(), is_watchdog)), is_watchdog)
        if is_watchdog:
            clock.watch(action).due_ns = when_ns
        else:
            clock.call_at(when_ns, action)
    clock.advance_to(20)
    assert clock.next_ns() == min((when_ns for _, when_ns in asked if when_ns > 20), default=None)
    clock.advance_to(50)
    assert called == sorted((when_ns, is_watchdog) for is_watchdog, when_ns in asked)


def test_a_timer_that_puts_a_watchdog_off_at_its_instant_is_in_time() -> None:
    clock = VirtualClock()
    watchdog = clock.watch(lambda: pytest.fail("put off"))
    watchdog.due_ns = 5

    def put_off() -> None:
        watchdog.due_ns = 100

    clock.call_at(5, put_off)
    assert clock.advance_to(50) == 100


orders = st.lists(st.tuples(st.integers(0, 4), st.sampled_from(["at", "after", "stop", "never"]), st.integers(0, 9)))


@given(orders)
def test_an_alarm_calls_as_a_timer_would_that_is_made_anew_each_time(orders: list[tuple[int, str, int]]) -> None:
    clock = VirtualClock()
    alarm, called, expected = Alarm(clock), list[tuple[int, int]](), list[tuple[int, int]]()
    due: tuple[int, int] | None = None
    for number, (wait_ns, order, value) in enumerate(orders):
        then_ns = clock.now_ns() + wait_ns
        if due is not None and due[0] <= then_ns:
            expected.append(due)
            due = None
        clock.advance_to(then_ns)

        def action(number: int = number) -> None:
            called.append((clock.now_ns(), number))

        match order:
            case "at":
                alarm.at(value, action)
                due = (max(value, then_ns), number)
            case "after":
                alarm.after(value, action)
                due = (then_ns + value, number)
            case "stop":
                alarm.stop()
                due = None
            case _:
                alarm.at(NEVER_NS if value % 2 else None, action)
                due = None
        assert alarm.is_set is (due is not None)
    clock.advance_to(100)
    assert called == [*expected, *([] if due is None else [due])]
    assert not alarm.is_set


def test_an_alarm_that_is_postponed_again_and_again_has_one_timer() -> None:
    clock = VirtualClock()
    alarm = Alarm(clock)
    for _ in range(1000):
        alarm.after(S, lambda: None)
        clock.advance_to(clock.now_ns() + MS)
    assert len(clock._timers.heap) == 1


def test_an_alarm_may_be_set_again_by_its_own_action() -> None:
    clock, called = VirtualClock(), list[int]()
    alarm = Alarm(clock)

    def again() -> None:
        called.append(clock.now_ns())
        if len(called) < 3:
            alarm.after(MS, again)

    alarm.after(MS, again)
    clock.advance_to(S)
    assert called == [MS, 2 * MS, 3 * MS]


@given(st.lists(st.integers(0, 1_000), max_size=50))
def test_timers_come_out_sorted_and_stable(asked: list[int]) -> None:
    queue = TimerQueue()
    order: list[tuple[int, int]] = []
    for place, when_ns in enumerate(asked):
        queue.add(when_ns, lambda when_ns=when_ns, place=place: order.append((when_ns, place)))  # type: ignore[misc]  # as above
    while (timer := queue.pop_due(1_000)) is not None:
        assert timer.action is not None
        timer.action()
    assert order == sorted((when_ns, place) for place, when_ns in enumerate(asked))


def test_a_real_period_does_not_drift_and_time_stands_within_an_event() -> None:
    instants: list[int] = []

    async def tick_five_times() -> int:
        clock = RealClock(asyncio.get_running_loop())
        done = asyncio.Event()
        start_ns = clock.now_ns() + MS

        def tick() -> None:
            instants.append(clock.now_ns())
            assert clock.now_ns() == instants[-1]
            if len(instants) == 5:
                done.set()
            else:
                clock.call_at(clock.now_ns() + MS, tick)

        clock.call_at(start_ns, tick)
        await done.wait()
        assert clock.lateness()["timers"] == 5
        clock.close()
        return start_ns

    start_ns = asyncio.run(tick_five_times())
    late_from = next((place for place, instant in enumerate(instants) if instant != start_ns + place * MS), 5)
    if late_from < 5:  # a machine that was blocked for STALL_NS continues from the present
        assert instants[late_from] - (start_ns + late_from * MS) >= STALL_NS


def test_a_real_event_happens_at_its_own_instant_unless_that_is_long_past() -> None:
    async def handle() -> list[int]:
        clock = RealClock(asyncio.get_running_loop())
        seen: list[int] = []
        now_ns = time.monotonic_ns()
        for instant_ns in (now_ns - MS, now_ns - 2 * MS, now_ns - S, now_ns + S):
            clock.handle_at(instant_ns, lambda: seen.append(clock.now_ns() - now_ns))
        clock.close()
        return seen

    at_its_own, not_backwards, too_old, not_yet = asyncio.run(handle())
    assert at_its_own == not_backwards == -MS
    assert 0 <= too_old <= not_yet < S


def test_an_earlier_timer_overtakes_one_that_is_armed() -> None:
    async def overtake() -> list[str]:
        clock = RealClock(asyncio.get_running_loop())
        done = asyncio.Event()
        called: list[str] = []
        later = clock.call_at(clock.now_ns() + 3600 * S, lambda: called.append("later"))
        clock.call_at(clock.now_ns() + MS, lambda: called.append("sooner"))
        clock.call_at(clock.now_ns() + 2 * MS, done.set)
        await done.wait()
        later.cancel()
        clock.close()
        return called

    assert asyncio.run(overtake()) == ["sooner"]


def test_a_real_watchdog_is_called_once_when_it_is_no_longer_put_off() -> None:
    async def bark() -> tuple[list[int], int, int]:
        clock = RealClock(asyncio.get_running_loop())
        done = asyncio.Event()
        called: list[int] = []

        def on_due() -> None:
            called.append(clock.now_ns())
            clock.call_at(clock.now_ns() + 5 * MS, done.set)

        watchdog = clock.watch(on_due)
        start_ns = clock.now_ns()
        watchdog.due_ns = start_ns + 3600 * S
        for later_ms in (30, 5, 20):  # sooner, sooner still, put off
            watchdog.due_ns = last_ns = start_ns + later_ms * MS
        await done.wait()
        clock.close()
        return called, last_ns, watchdog.due_ns

    called, due_ns, then_ns = asyncio.run(bark())
    assert len(called) == 1
    assert called[0] >= due_ns
    assert then_ns == NEVER_NS


def test_looking_is_no_event() -> None:
    """Values that are read together are of one instant, and a timer that is overdue meanwhile keeps its own."""

    async def look() -> tuple[list[int], list[int], int]:
        clock = RealClock(asyncio.get_running_loop())
        done = asyncio.Event()
        called: list[int] = []

        def on_timer() -> None:
            called.append(clock.now_ns())
            done.set()

        due_ns = clock.now_ns()
        clock.call_at(due_ns, on_timer)

        def read() -> list[int]:
            first = clock.now_ns()
            while time.monotonic_ns() == first:
                pass
            return [first, clock.now_ns()]

        seen = clock.look(read)
        await done.wait()
        clock.close()
        return seen, called, due_ns

    seen, called, due_ns = asyncio.run(look())
    assert seen[0] == seen[1] > due_ns
    assert called[0] == due_ns or called[0] - due_ns >= STALL_NS
