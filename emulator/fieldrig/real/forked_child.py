"""A child process of a rig's supervisor that is forked (Linux): how it begins, and how its end is seen."""

import asyncio
import logging
import os
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

from fieldrig.real import progress
from fieldrig.system import log_files
from fieldrig.system.exits import Exit

assert sys.platform == "linux", "only Linux has descriptors of processes"

log = logging.getLogger(__name__)

LOOK_S = 0.2
"""Time between two looks at a process, where the kernel has no descriptor to wait for its end."""
PIPE = 3
"""Number of the pipe for its steps."""


def fork_child(work: Callable[[], int], log: Path | None, lifeline: int, kept: Sequence[int]) -> int:
    """Run `work` in a new process, which exits with its result, and return its process id."""
    pid = os.fork()
    if pid == 0:
        _run_child(work, log, lifeline, kept)
    return pid


def _run_child(work: Callable[[], int], log: Path | None, lifeline: int, kept: Sequence[int]) -> NoReturn:
    """Run `work` in the forked process, with nothing of the parent but its imports.

    `kept` are the descriptors that it inherits, from 3 on; the first is the pipe for its steps.
    """
    code = int(Exit.CRASHED)
    try:
        os.setsid()
        for name in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(name, signal.SIG_DFL)
        os.dup2(lifeline, 0)
        if log is not None:
            log_files.direct_output(log)
        _keep_only(kept)
        if log is not None:
            log_files.take_over(log)
        progress.report_to(PIPE)
        progress.step("forked")
        code = work()
    except BaseException:
        sys.excepthook(*sys.exc_info())
        raise
    finally:
        # Not sys.exit: the frames above belong to the parent, and must not be unwound here.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _keep_only(kept: Sequence[int]) -> None:
    """Give the descriptors `kept` the numbers from `PIPE` on, and close all others above the output."""
    aside = [os.dup(number) for number in kept]  # a number that is kept may be one that is given
    while min(aside) < PIPE + len(kept):
        aside = [os.dup(number) for number in aside]
    for place, number in enumerate(aside, PIPE):
        os.dup2(number, place)
    os.closerange(PIPE + len(kept), os.sysconf("SC_OPEN_MAX"))


async def ended(pid: int) -> None:
    """Wait until a process has ended, which is still to be reaped."""
    loop = asyncio.get_running_loop()
    ended = asyncio.Event()
    try:
        fd = os.pidfd_open(pid)
    except OSError as cause:
        log.debug("no descriptor for process %d: %s", pid, cause)
        while os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
            await asyncio.sleep(LOOK_S)
        return
    loop.add_reader(fd, ended.set)
    try:
        await ended.wait()
    finally:
        loop.remove_reader(fd)
        os.close(fd)
