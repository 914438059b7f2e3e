"""Threads of a loop work while it waits, and never while it works."""

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
from fieldrig.loop.real_clock import RealClock
from fieldrig.loop.threaded_loop import ThreadedLoop, _Selector

ROUNDS = 300


@pytest.fixture
def loop() -> Iterator[ThreadedLoop]:
    loop = ThreadedLoop()
    yield loop
    loop.close()


@pytest.fixture
def _impatient() -> Iterator[None]:
    """Let the interpreter switch threads as often as possible."""
    interval_s = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(interval_s)


def in_a_thread(loop: ThreadedLoop, action: Callable[[], Any]) -> None:
    """Run the action in a thread while the loop waits."""

    def work() -> None:
        with loop.lock:
            action()

    loop.start_thread("worker", work)


@pytest.mark.usefixtures("_impatient")
def test_two_threads_never_work_at_once(loop: ThreadedLoop) -> None:
    inside: list[str] = []
    most = 0

    def act(who: str) -> None:
        nonlocal most
        inside.append(who)
        for _ in range(50):
            most = max(most, len(inside))
        inside.remove(who)

    def worker(who: str) -> None:
        for _ in range(ROUNDS):
            with loop.lock:
                act(who)

    async def host() -> None:
        for who in ("first", "second"):
            loop.start_thread(who, lambda who=who: worker(who))  # type: ignore[misc]  # a default keeps the loop's value
        for _ in range(ROUNDS):
            act("host")
            await asyncio.sleep(0)

    loop.run_until_complete(host())
    loop.close()  # waits for the threads
    assert most == 1


def test_a_thread_waits_until_the_loop_does(loop: ThreadedLoop) -> None:
    order: list[str] = []
    has_started = threading.Event()
    done = loop.create_future()

    def work() -> None:
        has_started.set()
        with loop.lock:
            order.append("worker")
            done.set_result(None)

    async def host() -> None:
        loop.start_thread("worker", work)
        has_started.wait()
        assert not loop.lock.acquire(blocking=False)
        order.append("host")
        await done

    loop.run_until_complete(host())
    assert order == ["host", "worker"]


@pytest.mark.parametrize(
    "ask",
    [
        lambda loop, action: loop.call_soon(action),
        lambda loop, action: loop.call_later(0.001, action),
        lambda loop, action: loop.call_at(loop.time(), action),
    ],
    ids=["call_soon", "call_later", "call_at"],
)
def test_a_call_from_a_thread_wakes_a_loop_without_events(
    loop: ThreadedLoop, ask: Callable[[ThreadedLoop, Callable[[], None]], object]
) -> None:
    done = loop.create_future()
    homes: list[int] = []

    def action() -> None:
        homes.append(threading.get_ident())
        done.set_result(None)

    in_a_thread(loop, lambda: ask(loop, action))
    loop.run_until_complete(done)
    assert homes == [threading.get_ident()]


def test_a_timer_from_a_thread_is_due(loop: ThreadedLoop) -> None:
    clock = RealClock(loop)
    done = loop.create_future()
    in_a_thread(loop, lambda: clock.call_at(clock.now_ns() + MS, lambda: done.set_result(clock.now_ns())))
    assert loop.run_until_complete(done) > 0
    clock.close()


def test_in_a_thread_the_loop_is_the_running_one(loop: ThreadedLoop) -> None:
    done = loop.create_future()
    in_a_thread(loop, lambda: done.set_result(asyncio.get_running_loop()))
    assert loop.run_until_complete(done) is loop


def test_the_loop_handles_what_a_thread_raises(loop: ThreadedLoop) -> None:
    handled = loop.create_future()
    loop.set_exception_handler(lambda _, context: handled.set_result(context["exception"]))
    in_a_thread(loop, lambda: int("seven"))
    fault = loop.run_until_complete(handled)
    assert isinstance(fault, ValueError)
    assert "in work" in "".join(traceback.format_exception(fault))  # where it came from is known


def test_a_thread_that_waits_when_the_loop_closes_ends() -> None:
    loop = ThreadedLoop()
    has_started, has_run = threading.Event(), threading.Event()

    def work() -> None:
        has_started.set()
        with loop.lock:
            has_run.set()

    loop.start_thread("worker", work)
    has_started.wait()
    assert not has_run.is_set()
    loop.close()
    assert has_run.is_set()
    assert "worker" not in {thread.name for thread in threading.enumerate()}
    loop.close()  # closing twice does no harm


class Meddler:
    """Replaces the lock, and changes the selector after `select` has found what is ready."""

    def __init__(self) -> None:
        self.meddle: Callable[[], object] = lambda: None

    def release(self) -> None:
        """Do nothing, as there is no other thread."""

    def acquire(self) -> None:
        self.meddle()


@pytest.fixture
def waiting() -> Iterator[tuple[_Selector, Meddler, socket.socket]]:
    """A selector with a socket that is ready."""
    meddler = Meddler()
    near, far = socket.socketpair()
    with _Selector(cast(threading.Lock, meddler)) as waiting, near, far:
        waiting.register(near, selectors.EVENT_READ, "the first")
        far.send(b"\0")
        yield waiting, meddler, near


def test_what_is_ready_is_found(waiting: tuple[_Selector, Meddler, socket.socket]) -> None:
    selector, _, _ = waiting
    assert [key.data for key, _ in selector.select()] == ["the first"]


def test_a_file_that_was_closed_meanwhile_is_not_ready(waiting: tuple[_Selector, Meddler, socket.socket]) -> None:
    selector, meddler, near = waiting
    meddler.meddle = lambda: selector.unregister(near)
    assert selector.select() == []


def test_a_new_file_with_the_same_number_is_not_taken_for_the_old_one(
    waiting: tuple[_Selector, Meddler, socket.socket],
) -> None:
    selector, meddler, near = waiting

    def renew() -> None:
        meddler.meddle = lambda: None
        selector.unregister(near)
        selector.register(near, selectors.EVENT_READ, "the second")

    meddler.meddle = renew
    assert selector.select() == []
    assert [key.data for key, _ in selector.select()] == ["the second"]
