"""Waits of the standard library take virtual time, and give the same run each time."""

import asyncio
import concurrent.futures
import ctypes.util
import datetime
import platform
import queue
import random
import sched
import select
import selectors
import socket
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from fieldrig import MS, Rig, S, from_dict, virtual_time

pytestmark = [pytest.mark.lean, pytest.mark.long, pytest.mark.timeout(60)]
EMPTY: dict[str, Any] = {"time": "virtual", "buses": {}, "devices": {}}


@pytest.fixture
def rig() -> Iterator[Rig]:
    """A rig of nothing, in whose time the test is."""
    with Rig(from_dict(EMPTY)) as rig, virtual_time(rig):
        yield rig


def virtual(body: Callable[[Rig], Any], **options: Any) -> Any:
    with Rig(from_dict(EMPTY)) as rig, virtual_time(rig, **options):
        return body(rig)


def pause(seconds: float) -> bool:
    time.sleep(seconds)
    return False


# ---- clocks


def test_ten_minutes_take_no_time_and_all_clocks_show_them(rig: Rig) -> None:
    clocks: tuple[Callable[[], float], ...] = (
        time.time,
        time.monotonic,
        time.perf_counter,
        lambda: time.clock_gettime(time.CLOCK_MONOTONIC),
    )
    before = [clock() for clock in clocks]
    nanoseconds = time.time_ns(), time.monotonic_ns(), time.perf_counter_ns()
    time.sleep(600)
    assert [clock() - start for clock, start in zip(clocks, before, strict=True)] == [600] * 4
    assert (time.time_ns(), time.monotonic_ns(), time.perf_counter_ns()) == tuple(x + 600 * S for x in nanoseconds)
    assert rig.now_ns == 600 * S


def test_dates_are_those_of_virtual_time(rig: Rig) -> None:
    time.sleep(23 * 3600)
    assert datetime.datetime.now(datetime.UTC) == datetime.datetime(2000, 1, 1, 23, tzinfo=datetime.UTC)
    assert time.gmtime()[:4] == (2000, 1, 1, 23)
    assert time.localtime() == time.localtime(time.time())
    assert datetime.date.today() == datetime.datetime.now().date()  # noqa: DTZ005, DTZ011
    assert time.strftime("%Y", time.gmtime()) == "2000"


def test_dates_that_were_made_in_virtual_time_are_ordinary_ones() -> None:
    def dates(_: Rig) -> list[Any]:
        made = [datetime.datetime.now(datetime.UTC), datetime.datetime(2020, 1, 1, tzinfo=datetime.UTC)]
        assert all(isinstance(date, datetime.datetime) and isinstance(date, datetime.date) for date in made)
        return [*made, datetime.date(2020, 1, 1)]

    kinds = [type(date) for date in virtual(dates)]
    assert kinds == [datetime.datetime, datetime.datetime, datetime.date]


class Moment(datetime.datetime):
    """A class that a program has made before the block."""


class Day(datetime.date):
    pass


class Fixed(Moment):
    @classmethod
    def now(cls, tz: datetime.tzinfo | None = None) -> "Fixed":
        return cls(1999, 1, 1, tzinfo=tz)


def test_classes_that_are_derived_from_dates_show_virtual_time() -> None:
    def dates(_: Rig) -> list[Any]:
        time.sleep(3600)

        class Inner(datetime.datetime): ...  # fmt: skip

        utc = datetime.UTC
        assert Inner.now(utc) == Moment.now(utc) == datetime.datetime.now(utc)
        assert Moment.utcnow() == datetime.datetime(2000, 1, 1, 1)  # noqa: DTZ001
        assert Moment.today() == datetime.datetime.now()  # noqa: DTZ005
        assert Fixed.now().year == 1999
        return [Moment.now(utc), Day.today(), Fixed.today(), Inner.now(utc)]

    names = [name for kind in (Moment, Day, Fixed) for name in vars(kind)]
    assert [type(date).__name__ for date in virtual(dates)] == ["Moment", "Day", "Fixed", "Inner"]
    assert [name for kind in (Moment, Day, Fixed) for name in vars(kind)] == names
    assert Moment.now(datetime.UTC).year > 2020


def test_a_busy_wait_for_an_instant_ends(rig: Rig) -> None:
    end_s = time.monotonic() + 0.05
    while time.monotonic() < end_s:
        pass
    assert rig.now_ns == 50 * MS


def test_names_that_a_module_has_taken_are_covered_and_given_back() -> None:
    class Timeout:
        """The clock is an attribute of a class, as in pyserial."""

        __module__ = __name__
        NOW: Any = time.monotonic

        def __init__(self, pause: Callable[[float], None] = time.sleep) -> None:
            self.pause = pause

    globals()["Timeout"] = Timeout
    real = Timeout.NOW, Timeout.__init__.__defaults__

    def body(_: Rig) -> float:
        timeout = Timeout()
        begin_s: float = timeout.NOW()
        timeout.pause(1000)
        return float(timeout.NOW() - begin_s)

    try:
        assert virtual(body) == 1000
        assert (Timeout.NOW, Timeout.__init__.__defaults__) == real
    finally:
        del globals()["Timeout"]


def test_everything_is_real_again_after_the_block() -> None:
    names = (
        (time, "time monotonic perf_counter sleep localtime strftime clock_gettime"),
        (threading, "Lock _allocate_lock _CRLock excepthook"),
        (threading.Thread, "join is_alive"),
        (select, "select poll epoll"),
        (socket, "getaddrinfo gethostbyname"),
        (socket.socket, "connect bind accept recv send sendall getpeername"),
        (datetime, "datetime date"),
        (queue, "SimpleQueue"),
    )

    def held() -> list[Any]:
        return [getattr(owner, name) for owner, words in names for name in words.split()]

    before = held()
    own = set(vars(socket.socket))
    virtual(lambda _: time.sleep(5))
    assert all(now is then for now, then in zip(held(), before, strict=True))
    assert set(vars(socket.socket)) == own


def test_a_thread_from_before_the_block_keeps_real_time() -> None:
    go, seen = threading.Event(), []

    def body() -> None:
        go.wait()
        seen.append(time.monotonic())

    thread = threading.Thread(target=body)
    thread.start()
    before_s = time.monotonic()

    def release(_: Rig) -> None:
        time.sleep(500_000)
        go.set()

    virtual(release, limit_s=1e6)
    thread.join()
    assert before_s <= seen[0] < before_s + 400_000


# ---- threads


def crowd(rig: Rig) -> list[Any]:
    """Return what four threads with a queue, a barrier, a semaphore and a condition did, and when."""
    log: list[Any] = []
    results: queue.Queue[tuple[int, int]] = queue.Queue(3)
    condition, some, all_of = threading.Condition(), threading.Semaphore(2), threading.Barrier(4)

    def work(number: int) -> None:
        pauses = random.Random(number)
        all_of.wait(timeout=10)
        for step in range(10):
            with some:
                time.sleep(pauses.choice([0, 0, 0.001, 0.002]))
            results.put((number, step))
            with condition:
                condition.notify()

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    log += [(results.get(timeout=5), rig.now_ns) for _ in range(40)]
    for thread in threads:
        thread.join(3)
        assert not thread.is_alive()
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        log += pool.map(lambda number: (pause(number / 100), number, rig.now_ns), range(12))
    return log


def test_threads_give_the_same_run_each_time() -> None:
    assert virtual(crowd) == virtual(crowd) == virtual(crowd)


def test_a_seed_of_jitter_gives_its_own_run_each_time() -> None:
    runs = {seed: virtual(crowd, jitter=0.01, seed=seed) for seed in (1, 2, 3)}
    assert runs[1] != runs[2] != runs[3] != virtual(crowd)
    assert runs == {seed: virtual(crowd, jitter=0.01, seed=seed) for seed in (1, 2, 3)}


def test_a_late_wake_up_is_at_most_the_jitter_late() -> None:
    def lateness_ns(rig: Rig) -> list[int]:
        late_ns = []
        for _ in range(50):
            due_ns = rig.now_ns + S
            time.sleep(1)
            late_ns.append(rig.now_ns - due_ns)
        return late_ns

    late_ns = virtual(lateness_ns, jitter=0.02)
    assert min(late_ns) >= 0
    assert 0 < max(late_ns) <= 20 * MS


def test_a_timer_calls_at_its_instant(rig: Rig) -> None:
    done = threading.Event()
    threading.Timer(7, done.set).start()
    assert not done.wait(6.5)
    assert done.wait(1)
    assert rig.now_ns == 7 * S


def test_an_empty_queue_times_out(rig: Rig) -> None:
    for kind in (queue.Queue[int], queue.SimpleQueue[int]):
        begin_ns = rig.now_ns
        with pytest.raises(queue.Empty):
            kind().get(timeout=60)
        assert rig.now_ns == begin_ns + 60 * S


def test_an_event_from_before_the_block_is_waited_for() -> None:
    done, lock = threading.Event(), threading.RLock()

    def body(rig: Rig) -> int:
        def finish() -> None:
            with lock:
                time.sleep(2)
                done.set()

        threading.Thread(target=finish).start()
        assert done.wait(10)
        return rig.now_ns

    assert virtual(body) == 2 * S


def test_a_lock_has_the_arguments_of_the_real_one(rig: Rig) -> None:
    lock = threading.Lock()
    assert lock.acquire(timeout=5)
    assert not lock.acquire(False)
    assert not lock.acquire(timeout=5)
    assert rig.now_ns == 5 * S
    for wrong in ((False, 1), (True, -2)):
        with pytest.raises(ValueError, match="timeout"):
            lock.acquire(*wrong)
    with pytest.raises(OverflowError):
        lock.acquire(True, 1e30)
    with pytest.raises(RuntimeError):
        threading.Lock().release()


def test_a_scheduler_of_the_standard_library_waits(rig: Rig) -> None:
    plan, seen = sched.scheduler(), []
    for delay_s in (5, 2):
        plan.enter(delay_s, 1, lambda: seen.append(rig.now_ns))
    plan.run()
    assert seen == [2 * S, 5 * S]


def test_a_thread_that_still_waits_ends_with_the_block() -> None:
    threads: list[threading.Thread] = []

    def body(_: Rig) -> None:
        threads.append(threading.Thread(target=threading.Event().wait))
        threads[0].start()
        time.sleep(2)

    virtual(body)
    assert not threads[0].is_alive()


def test_a_test_that_fails_fails_with_its_own_error_and_leaves_no_thread() -> None:
    before = threading.active_count()

    def body(_: Rig) -> None:
        threading.Thread(target=threading.Event().wait).start()
        time.sleep(5)
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        virtual(body)
    assert threading.active_count() == before


# ---- descriptors and event loops


def test_a_socket_of_a_pair_is_waited_for(rig: Rig) -> None:
    near, far = socket.socketpair()
    with near, far:
        threading.Thread(target=lambda: pause(2) or far.send(b"x")).start()
        near.settimeout(5)
        assert near.recv(1) == b"x"
        assert rig.now_ns == 2 * S
        with pytest.raises(TimeoutError):
            near.recv(1)
        assert rig.now_ns == 7 * S


def test_every_form_of_select_waits(rig: Rig) -> None:
    near, far = socket.socketpair()
    poll = select.poll()
    poll.register(near, select.POLLIN)
    with near, far, select.epoll() as epoll:
        epoll.register(near.fileno(), select.EPOLLIN)
        waits: list[Callable[[], Any]] = [
            lambda: select.select([near], [], [], 1),
            lambda: poll.poll(1000),
            lambda: epoll.poll(1),
        ]
        for number, wait in enumerate(waits, 1):
            assert not any(wait())
            assert rig.now_ns == number * S
        far.send(b"x")
        assert all(any(wait()) for wait in waits)
        assert rig.now_ns == 3 * S


@pytest.mark.skipif(not hasattr(select, "epoll"), reason="only Linux has epoll")
@pytest.mark.parametrize("once", ["EPOLLONESHOT", "EPOLLET"])
def test_what_epoll_says_only_once_is_not_lost(rig: Rig, once: str) -> None:
    near, far = socket.socketpair()
    with near, far, select.epoll() as epoll:
        epoll.register(near.fileno(), select.EPOLLIN | getattr(select, once))
        threading.Timer(3, far.send, [b"x"]).start()
        assert epoll.poll(10) == [(near.fileno(), select.EPOLLIN)]
        assert rig.now_ns == 3 * S
        assert epoll.poll(2) == []
        assert rig.now_ns == 5 * S


def test_questions_about_the_host_are_answered(rig: Rig) -> None:
    """The standard library asks a process for each of them, in real time."""
    assert ctypes.util.find_library("no-such-library") is None
    assert isinstance(platform.processor(), str)
    time.sleep(1)
    assert rig.now_ns == S


def test_asyncio_waits(rig: Rig) -> None:
    async def main() -> tuple[str, float]:
        loop, late = asyncio.get_running_loop(), asyncio.Queue[str]()
        begin_s = loop.time()
        threading.Timer(3, lambda: loop.call_soon_threadsafe(late.put_nowait, "late")).start()
        async with asyncio.timeout(100):
            got = await late.get()
            await asyncio.gather(*(asyncio.sleep(seconds) for seconds in (1, 4, 2)))
            await asyncio.gather(*(asyncio.to_thread(time.sleep, 1) for _ in range(5)))
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(asyncio.Event().wait(), 5)  # noqa: TID251 - a master may use it
        return got, loop.time() - begin_s

    assert asyncio.run(main()) == ("late", 3 + 4 + 1 + 5)


def test_two_event_loops_run_in_two_threads(rig: Rig) -> None:
    seen: list[tuple[float, int]] = []

    def run(period_s: float) -> None:
        async def main() -> None:
            for _ in range(3):
                await asyncio.sleep(period_s)
                seen.append((period_s, rig.now_ns // MS))

        asyncio.run(main())

    threads = [threading.Thread(target=run, args=(period_s,)) for period_s in (0.2, 0.3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    # At 600 ms both wake up, in the order in which they asked for it.
    assert seen == [(0.2, 200), (0.3, 300), (0.2, 400), (0.3, 600), (0.2, 600), (0.3, 900)]


@pytest.mark.parametrize("name", ["SelectSelector", "PollSelector", "EpollSelector"])
def test_an_event_loop_waits_with_every_selector(rig: Rig, name: str) -> None:
    if (kind := getattr(selectors, name, None)) is None:
        return

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await asyncio.sleep(2)
        writer.write((await reader.readexactly(1)) * 2)
        writer.close()

    async def talk() -> bytes:
        server = await asyncio.start_server(serve, "127.0.0.1", 7000)
        async with server:
            reader, writer = await asyncio.open_connection("127.0.0.1", 7000)
            writer.write(b"x")
            answer = await reader.readexactly(2)
            writer.close()
            return answer

    with asyncio.Runner(loop_factory=lambda: asyncio.SelectorEventLoop(kind())) as runner:
        assert runner.run(talk()) == b"xx"
    assert rig.now_ns == 2 * S
