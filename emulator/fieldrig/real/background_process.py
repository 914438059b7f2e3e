"""The background of devices in real time: a worker process for each piece of work, one after the other.

A thread of this process starts the worker and reads its answers, in pieces that don't keep the event loop from its
work; the loop then calls the device.  The thread never calls a device itself.  A worker doesn't inherit real-time
scheduling.  It ends with this process, however that ends, as it then reads the end of its standard input.
"""

import asyncio
import contextlib
import logging
import os
import pickle
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import IO, Any, Final, TypeVar

from fieldrig.loop.background import PROTOCOL, Failure, Function, Job, Report
from fieldrig.loop.real_clock import RealClock
from fieldrig.real.background_worker import FAILURE, HEAD, PART, REPORT, RESULT, WORK
from fieldrig.real.child import how_it_ended
from fieldrig.text.exception_notes import blame

log = logging.getLogger(__name__)

A = TypeVar("A")
R = TypeVar("R")

_PIECE: Final = 1 << 18  # bytes in one read
_JOIN_S: Final = 2.0


class BackgroundProcesses:
    """The background of all devices of one process.  Make it in the event loop; `close` ends what still works."""

    def __init__(self, clock: RealClock) -> None:
        self._clock = clock
        self._loop = asyncio.get_running_loop()
        self._waiting: deque[_Job] = deque()
        self._current: _Job | None = None

    def of(self, device: str) -> "RealBackground":
        return RealBackground(self, device)

    @property
    def pid(self) -> int | None:
        """The process id of the worker, or None while nothing is being done."""
        return None if self._current is None else self._current.pid

    def add(self, job: "_Job") -> None:
        self._waiting.append(job)
        self._begin_next()

    def cancel(self, job: "_Job") -> None:
        job.is_wanted = False
        if job is self._current:
            job.kill()
        elif job in self._waiting:
            self._waiting.remove(job)

    def close(self) -> None:
        """End the worker, and wait for its thread."""
        self._waiting.clear()
        if (job := self._current) is not None:
            self.cancel(job)
            job.join()

    def report(self, job: "_Job", report: tuple[str, int, int]) -> None:
        """Pass on a report.  The thread of the job calls this and `end`."""
        if job.on_progress is not None:
            self._post(partial(self._call, job, job.on_progress, *report))

    def end(self, job: "_Job", result: Any) -> None:
        self._post(partial(self._on_end, job, result))

    def _begin_next(self) -> None:
        if self._current is None and self._waiting:
            self._current = self._waiting.popleft()
            self._current.begin()

    def _on_end(self, job: "_Job", result: Any) -> None:
        self._current = None
        try:
            self._call(job, job.on_done, result)
        finally:
            self._begin_next()

    def _call(self, job: "_Job", action: Callable[..., None], *arguments: Any) -> None:
        if not job.is_wanted:
            return
        try:
            self._clock.handle(action, *arguments)
        except Exception as fault:
            blame(fault, job.device, None, self._clock.now_ns())
            raise

    def _post(self, action: Callable[[], None]) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(action)


class RealBackground:
    """The background of one device in real time."""

    def __init__(self, processes: BackgroundProcesses, device: str) -> None:
        self._processes, self._device = processes, device

    def run(
        self,
        function: Function[A, R],
        argument: A,
        on_done: Callable[[R | Failure], None],
        on_progress: Report | None = None,
        *,
        virtual_ns: int,
    ) -> Job:
        work = pickle.dumps((sys.path, pickle.dumps((function, argument), PROTOCOL)), PROTOCOL)
        job = _Job(self._processes, self._device, work, on_done, on_progress)
        self._processes.add(job)
        return job


class _Job:
    def __init__(
        self,
        processes: BackgroundProcesses,
        device: str,
        work: bytes,
        on_done: Callable[[Any], None],
        on_progress: Report | None,
    ) -> None:
        self._processes, self.device, self._work = processes, device, work
        self.on_done, self.on_progress = on_done, on_progress
        self.is_wanted = True
        self._process: subprocess.Popen[bytes] | None = None
        self._thread = threading.Thread(target=self._run, name=f"background {device}", daemon=True)
        self._lock = threading.Lock()

    @property
    def pid(self) -> int | None:
        return None if self._process is None else self._process.pid

    def begin(self) -> None:
        self._thread.start()

    def cancel(self) -> None:
        self._processes.cancel(self)

    def kill(self) -> None:
        with self._lock:
            if self._process is not None:
                self._process.kill()

    def join(self) -> None:
        self._thread.join(_JOIN_S)

    # ---- in the thread of the job

    def _run(self) -> None:
        result: Any
        try:
            result = self._outcome()
        except OSError as cause:
            result = Failure(f"the worker process cannot be started: {cause}")
        self._processes.end(self, result)

    def _outcome(self) -> Any:
        _keep_realtime_here()
        command = [sys.executable, "-u", "-m", "fieldrig.real.background_worker"]
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0, start_new_session=True
        ) as process:
            with self._lock:
                self._process = process
                if not self.is_wanted:
                    process.kill()
            assert process.stdin is not None
            assert process.stdout is not None
            try:
                process.stdin.write(HEAD.pack(WORK, len(self._work)))
                _write(process.stdin, self._work)
                return self._answer(process.stdout)
            except (EOFError, BrokenPipeError):
                process.stdin.close()
                how = how_it_ended(process.wait())
                if self.is_wanted:
                    log.error("%s: the worker process has ended, %s", self.device, how)
                return Failure(f"the worker process has ended, {how}")
            finally:
                process.kill()  # what is done has nothing more to do

    def _answer(self, stream: IO[bytes]) -> Any:
        parts: list[bytearray] = []
        while True:
            kind, size = HEAD.unpack(_read(stream, HEAD.size))
            data = _read(stream, size)
            if kind == PART:
                parts.append(data)
            elif kind == REPORT:
                self._processes.report(self, pickle.loads(data))
            elif kind == RESULT:
                return pickle.loads(data, buffers=parts)
            else:
                assert kind == FAILURE
                return Failure(data.decode(errors="replace"))


def _keep_realtime_here() -> None:
    """Let the worker start with usual scheduling if this process has real-time scheduling."""
    if sys.platform == "linux":
        with contextlib.suppress(PermissionError, AttributeError):
            if (policy := os.sched_getscheduler(0)) in (os.SCHED_FIFO, os.SCHED_RR):
                os.sched_setscheduler(0, policy | os.SCHED_RESET_ON_FORK, os.sched_getparam(0))


def _write(stream: IO[bytes], data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[stream.write(view[:_PIECE]) :]


def _read(stream: IO[bytes], size: int) -> bytearray:
    """Read exactly `size` bytes.  EOFError if the stream ends before."""
    data = bytearray(size)
    view = memoryview(data)
    offset = 0
    while offset < size:
        count = stream.readinto(view[offset : offset + _PIECE])  # type: ignore[attr-defined]
        if not count:
            raise EOFError
        offset += count
    view.release()
    return data
