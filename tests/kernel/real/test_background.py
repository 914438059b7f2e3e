"""Long work of devices beside them, in virtual time and in processes."""

import asyncio
import os
import pickle
import select
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import background_work as work
import pytest
from in_loop import in_loop

from fieldrig.clock import MS, VirtualClock
from fieldrig.loop.background import Bulk, Coarse, Failure, VirtualBackground, packed, unpacked
from fieldrig.loop.real_clock import RealClock
from fieldrig.real.background_process import BackgroundProcesses

# ---- virtual time


def test_a_result_arrives_after_its_virtual_time_with_reports_at_equal_distances() -> None:
    clock = VirtualClock(5 * MS)
    heard: list[Any] = []
    VirtualBackground(clock).run(
        work.squares,
        3,
        lambda result: heard.append((clock.now_ns(), result)),
        lambda *report: heard.append((clock.now_ns(), *report)),
        virtual_ns=8 * MS,
    )
    assert heard == []
    clock.advance_to(100 * MS)
    assert heard == [
        (7 * MS, "squaring", 0, 3),
        (9 * MS, "squaring", 1, 3),
        (11 * MS, "squaring", 2, 3),
        (13 * MS, [0, 1, 4]),
    ]


def test_cancelled_work_of_virtual_time_is_not_heard_of_again() -> None:
    clock, heard = VirtualClock(), list[Any]()
    VirtualBackground(clock).run(work.squares, 3, heard.append, virtual_ns=MS).cancel()
    clock.advance_to(2 * MS)
    assert heard == []


def test_a_fault_of_the_work_is_loud_in_virtual_time() -> None:
    with pytest.raises(LookupError):
        VirtualBackground(VirtualClock()).run(work.wrong, None, print, virtual_ns=MS)


def test_the_result_is_a_copy_as_from_another_process() -> None:
    clock, heard = VirtualClock(), list[Any]()
    given = [1, 2]
    VirtualBackground(clock).run(_same, given, heard.append, virtual_ns=0)
    given.append(3)
    clock.advance_to(0)
    assert heard == [[1, 2]]


def _same(argument: list[int], report: object) -> list[int]:
    return argument


def test_reports_are_a_hundredth_apart() -> None:
    heard: list[tuple[str, int, int]] = []
    coarse = Coarse(lambda *report: heard.append(report))
    for done in range(10_001):
        coarse("parsing", done, 10_000)
    coarse("checking", 0, 0)
    assert heard == [("parsing", done, 10_000) for done in range(0, 10_001, 100)] + [("checking", 0, 0)]


def test_a_packed_object_is_the_same_after_a_journey() -> None:
    there = pickle.loads(pickle.dumps(packed({"a": [1, 2.5, None]}), 5))
    assert unpacked(there) == {"a": [1, 2.5, None]}


# ---- processes


class Bench:
    def __init__(self, processes: BackgroundProcesses) -> None:
        self.processes = processes
        self.heard: asyncio.Queue[Any] = asyncio.Queue()
        self.reports: asyncio.Queue[tuple[str, int, int]] = asyncio.Queue()

    def run(self, function: Any, argument: Any) -> Any:
        return self.processes.of("card").run(
            function, argument, self.heard.put_nowait, lambda *report: self.reports.put_nowait(report), virtual_ns=MS
        )

    async def result(self, function: Callable[..., Any], argument: Any) -> Any:
        self.run(function, argument)
        return await self.heard.get()


@asynccontextmanager
async def a_bench() -> AsyncIterator[Bench]:
    clock = RealClock(asyncio.get_running_loop())
    processes = BackgroundProcesses(clock)
    try:
        yield Bench(processes)
    finally:
        processes.close()
        clock.close()


@pytest.mark.system
@in_loop
async def test_a_result_comes_from_another_process() -> None:
    async with a_bench() as bench:
        assert await bench.result(work.squares, 4) == [0, 1, 4, 9]
        assert bench.reports.get_nowait() == ("squaring", 0, 4)
        assert bench.processes.pid is None


@pytest.mark.system
@in_loop
async def test_large_parts_arrive_whole() -> None:
    async with a_bench() as bench:
        name, bulk = await bench.result(work.large, 5_000_000)
        assert isinstance(bulk, Bulk)
        assert (name, bytes(bulk.data) == bytes(range(256)) * (5_000_000 // 256)) == ("large", True)


@pytest.mark.system
@in_loop
async def test_the_loop_goes_on_while_the_work_is_held(tmp_path: Path) -> None:
    gate = tmp_path / "gate"
    os.mkfifo(gate)
    async with a_bench() as bench:
        bench.run(work.wait_for, str(gate))
        assert await bench.reports.get() == ("waiting", 1, 2)
        for _ in range(1_000):
            await asyncio.sleep(0)
        assert bench.heard.empty()
        await asyncio.to_thread(gate.write_text, "open")
        assert await bench.heard.get() == "open"


@pytest.mark.system
@in_loop
async def test_a_worker_stands_back_behind_the_devices() -> None:
    async with a_bench() as bench:
        assert await bench.result(work.facts, None) == (min(os.nice(0) + 10, 19), os.SCHED_OTHER)


@pytest.mark.system
@in_loop
async def test_a_worker_that_is_killed_or_ends_is_a_failure(tmp_path: Path) -> None:
    gate = tmp_path / "gate"
    os.mkfifo(gate)
    async with a_bench() as bench:
        bench.run(work.wait_for, str(gate))
        await bench.reports.get()
        assert bench.processes.pid is not None
        os.kill(bench.processes.pid, signal.SIGKILL)
        assert await bench.heard.get() == Failure("the worker process has ended, killed by SIGKILL")
        assert await bench.result(work.end, 99) == Failure("the worker process has ended, exit code 99")
        assert await bench.result(work.squares, 2) == [0, 1]  # the next one is not affected


@pytest.mark.system
@in_loop
async def test_an_exception_is_a_failure() -> None:
    async with a_bench() as bench:
        assert await bench.result(work.wrong, None) == Failure("LookupError: no such thing")
        failure = await bench.result(work.unpicklable, None)
        assert isinstance(failure, Failure)
        assert "pickle" in failure.why


@pytest.mark.system
@in_loop
@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not limit the memory of a process")
async def test_work_that_needs_too_much_memory_is_a_failure() -> None:
    async with a_bench() as bench:
        failure = await bench.result(work.fill, 4 << 30)
    assert failure == Failure("it needs more memory than the 3072 MB of a worker process")


@pytest.mark.system
@in_loop
async def test_what_the_work_prints_is_not_its_answer() -> None:
    async with a_bench() as bench:
        assert await bench.result(work.talk, "hello\n" * 1_000) == 6_000


@pytest.mark.system
@in_loop
async def test_work_is_done_one_after_the_other_and_can_be_cancelled(tmp_path: Path) -> None:
    gate = tmp_path / "gate"
    os.mkfifo(gate)
    async with a_bench() as bench:
        first = bench.run(work.wait_for, str(gate))
        await bench.reports.get()
        second = bench.run(work.squares, 2)
        bench.run(work.squares, 3)
        second.cancel()
        assert bench.heard.empty()
        first.cancel()
        assert await bench.heard.get() == [0, 1, 4]
        assert bench.heard.empty()


@pytest.mark.system
@in_loop
async def test_a_worker_ends_with_its_process(tmp_path: Path) -> None:
    gate = tmp_path / "gate"
    os.mkfifo(gate)
    async with a_bench() as bench:
        bench.run(work.wait_for, str(gate))
        await bench.reports.get()
        pid = bench.processes.pid
    assert pid is not None
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.system
def test_a_worker_ends_when_the_process_of_the_device_is_killed(tmp_path: Path) -> None:
    gate = tmp_path / "gate"
    os.mkfifo(gate)
    paths = {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(
        [sys.executable, "-c", "import background_work; background_work.main()", str(gate)],
        stdout=subprocess.PIPE,
        env={**os.environ, **paths},
    ) as host:
        try:
            assert host.stdout is not None
            worker = os.pidfd_open(int(host.stdout.readline()))
        finally:
            host.kill()
    try:
        assert select.select([worker], [], [], 60)[0] == [worker]
    finally:
        os.close(worker)
