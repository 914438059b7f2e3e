"""One child process of a rig's supervisor, and its log.

At the start of a rig it is forked where the system allows it (Linux), because the supervisor has already read the rig
file and imported its kinds, which is most of the work of a start.  A restart spawns a new process, which runs the code
that is installed then.
"""

import asyncio
import errno
import gc
import logging
import os
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from pathlib import Path

from fieldrig.config.rig_file import RigConfig
from fieldrig.errors import RigError
from fieldrig.real.placement import ProcessPlan
from fieldrig.system import log_files
from fieldrig.system.exits import ABOUT, KILL, Exit
from fieldrig.system.own_files import open_file, refused
from fieldrig.text.exception_notes import NOTE

log = logging.getLogger(__name__)

TAIL_LINES = 20
FIRST_KEPT = 4
"""Number of the descriptor that a forked child inherits beside the pipe for its steps."""
CAN_FORK = sys.platform == "linux" and hasattr(os, "pidfd_open")
HAS_STEPS = os.name == "posix"
"""True if a child can report the steps of its start through a pipe; otherwise only its messages count as progress."""


def command(config: RigConfig, plan: ProcessPlan, overrides: Sequence[str], is_realtime: bool) -> list[str]:
    """Return the arguments of `fieldrig.real.host` for this process."""
    line = [str(config.path), "--process", plan.name]
    line += ["--buses", ",".join(plan.buses), "--devices", ",".join(plan.devices)]
    for override in overrides:
        line += ["--set", override]
    return [*line, "--realtime"] if is_realtime else line


def not_started(cause: OSError, name: str, remedy: str) -> RigError:
    """Return the error for a process that the system has no room for, or whose log cannot be opened."""
    if cause.filename is not None and cause.errno not in (errno.EMFILE, errno.ENFILE):
        return refused(cause)
    return RigError(
        f"the system has no room for the process {name}: {cause.strerror or cause}", f"see ulimit -a; {remedy}"
    )


class Child:
    """A process that can be started several times with one log, which begins with the rig.

    `lifeline` is the reading end of a pipe without traffic; its end of file tells the child that its parent is gone.
    Through another pipe the child reports the steps of its start (`progress`).
    """

    def __init__(
        self,
        arguments: Sequence[str],
        log: Path | None,
        lifeline: int,
        *,
        module: str = "fieldrig.real.host",
        kept: int | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        """`module` has the `main` of a spawned child, `environment` is added to its own.

        `kept` is a descriptor that the child inherits: a forked one at `FIRST_KEPT`, a spawned one under its number,
        which is added to the arguments.  Without a log the child writes to the output of its parent.
        """
        self._arguments, self._log, self._lifeline = arguments, log, lifeline
        self._module, self._kept, self._environment = module, kept, environment or {}
        self._log_start = 0
        self._is_fresh = True
        self._process: asyncio.subprocess.Process | None = None
        self._forked_pid: int | None = None
        self._steps: int | None = None
        self._on_step: Callable[[str], None] = lambda _step: None

    @property
    def pid(self) -> int | None:
        """The process id, or None when the process has ended."""
        if self._process is not None:
            return None if self._process.returncode is not None else self._process.pid
        return self._forked_pid

    def fork(self, work: Callable[[], int]) -> None:
        """Run `work` in a new process, which exits with its result.  Call it only while there is a single thread."""
        sys.stdout.flush()
        sys.stderr.flush()
        gc.freeze()  # what is there now is never touched again, and so stays shared
        self._begin_log()
        pipe = self._new_pipe()
        if sys.platform == "linux":
            from fieldrig.real.forked_child import fork_child

            kept = (pipe,) if self._kept is None else (pipe, self._kept)
            self._forked_pid = fork_child(work, self._log, self._lifeline, kept)
        os.close(pipe)

    async def spawn(self) -> None:
        self._begin_log()
        pipes = (self._new_pipe(),) if HAS_STEPS else ()
        kept = () if self._kept is None else (self._kept,)
        own_log = () if self._log is None else ("--log", str(self._log))
        try:
            with nullcontext() if self._log is None else open_file(self._log, "ab") as log:
                self._process = await asyncio.create_subprocess_exec(
                    *(sys.executable, "-u", "-m", "fieldrig.real.spawned", ",".join(map(str, pipes)), self._module),
                    *(*self._arguments, *map(str, kept), *own_log),
                    stdin=self._lifeline,
                    stdout=log,
                    stderr=None if log is None else asyncio.subprocess.STDOUT,
                    env={**os.environ, **self._environment},
                    pass_fds=(*pipes, *kept),
                    start_new_session=True,  # Ctrl-C is the parent's to handle
                )
        finally:
            for pipe in pipes:
                os.close(pipe)

    def follow(self, on_step: Callable[[str], None]) -> None:
        """Call `on_step` with the latest step whenever the child reports progress."""
        self._on_step = on_step
        if self._steps is not None:
            asyncio.get_running_loop().add_reader(self._steps, self.look)

    def look(self) -> None:
        """Read what the child has reported so far."""
        if self._steps is None:
            return
        try:
            report = os.read(self._steps, 1 << 16)
        except BlockingIOError:
            return
        if report:
            self._on_step(report.decode(errors="replace").splitlines()[-1])
        else:
            self.forget_steps()

    def forget_steps(self) -> None:
        """Close the pipe of a child that is ready or has ended."""
        if self._steps is not None:
            with suppress(RuntimeError):  # there is no loop any more
                asyncio.get_running_loop().remove_reader(self._steps)
            os.close(self._steps)
            self._steps = None

    def note(self, text: str) -> None:
        """Add a line of the supervisor to the child's log."""
        if self._log is None:
            return
        # A full disk is no reason to end a rig.
        with suppress(OSError), open_file(self._log, "a", encoding="utf-8") as log:
            log.write(f"{time.strftime('%Y-%m-%d %H:%M:%S')} supervisor: {text}\n")

    def _begin_log(self) -> None:
        if self._log is None:
            return
        if self._is_fresh:
            self._is_fresh = False
            log_files.begin_anew(self._log)
        elif log_files.is_full(self._log):
            log_files.rotate(self._log)
        self._log_start = self._log.stat().st_size if self._log.exists() else 0

    def _new_pipe(self) -> int:
        """Return the writing end of a new pipe for the steps."""
        self.forget_steps()
        self._steps, pipe = os.pipe()
        if hasattr(os, "set_blocking"):
            os.set_blocking(self._steps, False)
        return pipe

    async def wait(self) -> int:
        """Wait for the end, and return the exit code; a negative one is a signal."""
        if self._process is not None:
            return await self._process.wait()
        assert self._forked_pid is not None
        if sys.platform == "linux":
            from fieldrig.real.forked_child import ended

            await ended(self._forked_pid)
        return self.reap()

    def reap(self) -> int:
        """Return the exit code of a forked process that has ended or is about to end."""
        assert self._forked_pid is not None
        _, status = os.waitpid(self._forked_pid, 0)
        self._forked_pid = None
        return os.waitstatus_to_exitcode(status)

    def kill(self) -> None:
        """Kill the process without a loop, if it still runs."""
        if self.pid is not None:
            self.end(KILL)
            if self._forked_pid is not None:
                self.reap()

    def end(self, number: signal.Signals) -> None:
        if self.pid is not None:
            with suppress(ProcessLookupError):
                os.kill(self.pid, number)

    def tail(self) -> str:
        """Return the last lines that the process wrote since it was started; none if its log cannot be read."""
        try:
            return self._tail()
        except OSError:
            return ""

    def _tail(self) -> str:
        if self._log is None:
            return ""
        with open_file(self._log, "rb") as log:
            size = log.seek(0, os.SEEK_END)
            start = self._log_start if self._log_start <= size else 0  # it may have begun another file
            log.seek(max(start, size - 8_192))
            lines = log.read().decode(errors="replace").splitlines()
        return "\n".join(lines[-TAIL_LINES:])


def how_it_ended(code: int) -> str:
    if code < 0:
        return f"killed by {signal.Signals(-code).name}"
    known = {Exit.CRASHED, Exit.WRONG, Exit.CANNOT_START}
    return f"exit code {code}" + (f": {ABOUT[Exit(code)].partition(' (')[0]}" if code in known else "")


def why_it_ended(code: int, said: str) -> str:
    """Return the reason in one line; for a fault in its code, with the last line of the traceback that it has left."""
    lines = said.splitlines() if code in (Exit.CRASHED, Exit.BUG) else []
    is_noted = len(lines) > 1 and lines[-1].startswith(NOTE)
    return how_it_ended(code) + (f" ({', '.join(lines[-2:] if is_noted else lines[-1:])})" if lines else "")
