"""A loop whose turn guests take: they do as the loop would, and never while it does."""

import asyncio
import selectors
import socket
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from typing import Any, cast

import pytest

from fieldrig.clock import MS
from fieldrig.real_clock import RealClock
from fieldrig.shared_loop import SharedLoop, _Waiting

ROUNDS = 300


@pytest.fixture
def loop() -> Iterator[SharedLoop]:
    loop = SharedLoop()
    yield loop
    loop.close()


@pytest.fixture
def _impatient() -> Iterator[None]:
    """Threads change as often as they can."""
    interval_s = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(interval_s)


def in_a_turn(loop: SharedLoop, action: Callable[[], Any]) -> None:
    """A guest does it while the loop waits."""

    def life() -> None:
        with loop.turn:
            action()

    loop.invite("guest", life)


@pytest.mark.usefixtures("_impatient")
def test_nobody_is_in_the_world_while_another_is(loop: SharedLoop) -> None:
    inside: list[str] = []
    most = 0

    def act(who: str) -> None:
        nonlocal most
        inside.append(who)
        for _ in range(50):
            most = max(most, len(inside))
        inside.remove(who)

    def guest(who: str) -> None:
        for _ in range(ROUNDS):
            with loop.turn:
                act(who)

    async def host() -> None:
        for who in ("first", "second"):
            loop.invite(who, lambda who=who: guest(who))  # type: ignore[misc]  # a default keeps the loop's value
        for _ in range(ROUNDS):
            act("host")
            await asyncio.sleep(0)

    loop.run_until_complete(host())
    loop.close()  # guests come to their end
    assert most == 1


def test_a_guest_waits_until_the_loop_does(loop: SharedLoop) -> None:
    order: list[str] = []
    has_come = threading.Event()
    done = loop.create_future()

    def life() -> None:
        has_come.set()
        with loop.turn:
            order.append("guest")
            done.set_result(None)

    async def host() -> None:
        loop.invite("guest", life)
        has_come.wait()
        assert not loop.turn.acquire(blocking=False)
        order.append("host")
        await done

    loop.run_until_complete(host())
    assert order == ["host", "guest"]


@pytest.mark.parametrize(
    "ask",
    [
        lambda loop, action: loop.call_soon(action),
        lambda loop, action: loop.call_later(0.001, action),
        lambda loop, action: loop.call_at(loop.time(), action),
    ],
    ids=["call_soon", "call_later", "call_at"],
)
def test_what_a_guest_asks_of_a_loop_that_waits_for_nothing_is_done(
    loop: SharedLoop, ask: Callable[[SharedLoop, Callable[[], None]], object]
) -> None:
    done = loop.create_future()
    homes: list[int] = []

    def action() -> None:
        homes.append(threading.get_ident())
        done.set_result(None)

    in_a_turn(loop, lambda: ask(loop, action))
    loop.run_until_complete(done)
    assert homes == [threading.get_ident()]


def test_a_timer_that_a_guest_starts_is_kept(loop: SharedLoop) -> None:
    clock = RealClock(loop)
    done = loop.create_future()
    in_a_turn(loop, lambda: clock.call_at(clock.now_ns() + MS, lambda: done.set_result(clock.now_ns())))
    assert loop.run_until_complete(done) > 0
    clock.close()


def test_to_a_guest_the_loop_is_the_running_one(loop: SharedLoop) -> None:
    done = loop.create_future()
    in_a_turn(loop, lambda: done.set_result(asyncio.get_running_loop()))
    assert loop.run_until_complete(done) is loop


def test_what_a_guest_raises_is_the_loops_to_handle(loop: SharedLoop) -> None:
    handled = loop.create_future()
    loop.set_exception_handler(lambda _, context: handled.set_result(context["exception"]))
    in_a_turn(loop, lambda: int("seven"))
    fault = loop.run_until_complete(handled)
    assert isinstance(fault, ValueError)
    assert "in life" in "".join(traceback.format_exception(fault))  # where it came from is known


def test_a_guest_that_still_waits_when_the_loop_closes_comes_to_its_end() -> None:
    loop = SharedLoop()
    has_come, had_its_turn = threading.Event(), threading.Event()

    def life() -> None:
        has_come.set()
        with loop.turn:
            had_its_turn.set()

    loop.invite("guest", life)
    has_come.wait()
    assert not had_its_turn.is_set()
    loop.close()
    assert had_its_turn.is_set()
    assert "guest" not in {thread.name for thread in threading.enumerate()}
    loop.close()  # as often as one likes


class Meddler:
    """In place of the turn: what a guest does between what is ready being known and the loop having its turn."""

    def __init__(self) -> None:
        self.meddle: Callable[[], object] = lambda: None

    def release(self) -> None:
        """Nobody else is there."""

    def acquire(self) -> None:
        self.meddle()


@pytest.fixture
def waiting() -> Iterator[tuple[_Waiting, Meddler, socket.socket]]:
    """It waits for a socket which is ready."""
    meddler = Meddler()
    near, far = socket.socketpair()
    with _Waiting(cast(threading.Lock, meddler)) as waiting, near, far:
        waiting.register(near, selectors.EVENT_READ, "the first")
        far.send(b"\0")
        yield waiting, meddler, near


def test_what_is_ready_is_found(waiting: tuple[_Waiting, Meddler, socket.socket]) -> None:
    selector, _, _ = waiting
    assert [key.data for key, _ in selector.select()] == ["the first"]


def test_what_a_guest_closed_meanwhile_is_not_ready(waiting: tuple[_Waiting, Meddler, socket.socket]) -> None:
    selector, meddler, near = waiting
    meddler.meddle = lambda: selector.unregister(near)
    assert selector.select() == []


def test_a_new_thing_of_the_same_number_is_not_taken_for_the_old_one(
    waiting: tuple[_Waiting, Meddler, socket.socket],
) -> None:
    selector, meddler, near = waiting

    def renew() -> None:
        meddler.meddle = lambda: None
        selector.unregister(near)
        selector.register(near, selectors.EVENT_READ, "the second")

    meddler.meddle = renew
    assert selector.select() == []
    assert [key.data for key, _ in selector.select()] == ["the second"]
