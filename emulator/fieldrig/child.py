"""One process of a rig, as its supervisor holds it, and its log.

At the start of a rig it is forked where that is safe and can be waited for (Linux): the supervisor has read the rig
file and imported its kinds, and that is most of what a process does before it can work.  When it is started again it
is spawned anew, so that it runs the code that is there then.
"""

import asyncio
import gc
import os
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

from fieldrig.config import RigConfig
from fieldrig.exits import ABOUT, Exit
from fieldrig.placement import ProcessPlan

TAIL_LINES = 20
CAN_FORK = hasattr(os, "pidfd_open")


def command(config: RigConfig, plan: ProcessPlan, overrides: Sequence[str], is_realtime: bool) -> list[str]:
    """The command line of a host."""
    line = [sys.executable, "-u", "-m", "fieldrig.host", str(config.path), "--process", plan.name]
    line += ["--buses", ",".join(plan.buses), "--devices", ",".join(plan.devices)]
    for override in overrides:
        line += ["--set", override]
    return [*line, "--realtime"] if is_realtime else line


class Child:
    """Its log begins anew with the rig and goes on when it is spawned again.

    `leash` is the reading end of a pipe that nobody writes to: its end tells the child that its parent is gone.
    """

    def __init__(self, command: Sequence[str], log: Path, leash: int) -> None:
        self._command, self._log, self._leash = command, log, leash
        self._log_start = 0
        self._is_fresh = True
        self._process: asyncio.subprocess.Process | None = None
        self._forked_pid: int | None = None

    @property
    def pid(self) -> int | None:
        """None when it has ended."""
        if self._process is not None:
            return None if self._process.returncode is not None else self._process.pid
        return self._forked_pid

    def fork(self, work: Callable[[], int]) -> None:
        """Run `work` in a process of its own, which ends with its result.  Only while there is but one thread."""
        sys.stdout.flush()
        sys.stderr.flush()
        gc.freeze()  # what is there now is never touched again, and so stays shared
        self._is_fresh = False
        self._log.write_bytes(b"")
        pid = os.fork()
        if pid == 0:
            _live(work, self._log, self._leash)
        self._forked_pid = pid

    async def spawn(self) -> None:
        with self._log.open("wb" if self._is_fresh else "ab") as log:
            self._is_fresh = False
            self._log_start = log.tell()
            self._process = await asyncio.create_subprocess_exec(
                *self._command,
                stdin=self._leash,
                stdout=log,
                stderr=asyncio.subprocess.STDOUT,
                start_new_session=True,  # Ctrl-C is the parent's to handle
            )

    async def wait(self) -> int:
        """Its exit code; less than 0 is a signal."""
        if self._process is not None:
            return await self._process.wait()
        assert self._forked_pid is not None
        await _ended(self._forked_pid)
        return self.reap()

    def reap(self) -> int:
        """The exit code of a forked process that has ended, or ends at once."""
        assert self._forked_pid is not None
        _, status = os.waitpid(self._forked_pid, 0)
        self._forked_pid = None
        return os.waitstatus_to_exitcode(status)

    def end(self, number: signal.Signals) -> None:
        if self.pid is not None:
            with suppress(ProcessLookupError):
                os.kill(self.pid, number)

    def tail(self) -> str:
        """The last lines that it wrote since it was started."""
        with self._log.open("rb") as log:
            size = log.seek(0, os.SEEK_END)
            log.seek(max(self._log_start, size - 8_192))
            lines = log.read().decode(errors="replace").splitlines()
        return "\n".join(lines[-TAIL_LINES:])


def how_it_ended(code: int) -> str:
    if code < 0:
        return f"killed by {signal.Signals(-code).name}"
    known = {Exit.CRASHED, Exit.WRONG, Exit.CANNOT_START}
    return f"exit code {code}" + (f": {ABOUT[Exit(code)].partition(' (')[0]}" if code in known else "")


def _live(work: Callable[[], int], log: Path, leash: int) -> NoReturn:
    """In the new process: nothing of the parent's but what is imported."""
    code = int(Exit.CRASHED)
    try:
        os.setsid()
        for name in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(name, signal.SIG_DFL)
        os.dup2(leash, 0)
        output = os.open(log, os.O_WRONLY | os.O_APPEND)
        os.dup2(output, 1)
        os.dup2(output, 2)
        os.closerange(3, os.sysconf("SC_OPEN_MAX"))
        sys.stdout = os.fdopen(1, "w", buffering=1, closefd=False)
        sys.stderr = os.fdopen(2, "w", buffering=1, closefd=False)
        code = work()
    except BaseException:
        sys.excepthook(*sys.exc_info())
        raise
    finally:
        # Not sys.exit: the frames above belong to the parent, and must not be unwound here.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


async def _ended(pid: int) -> None:
    loop = asyncio.get_running_loop()
    ended = asyncio.Event()
    fd = os.pidfd_open(pid)
    loop.add_reader(fd, ended.set)
    try:
        await ended.wait()
    finally:
        loop.remove_reader(fd)
        os.close(fd)
