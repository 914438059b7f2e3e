"""The commands of the stages, which end in order when the run is interrupted.

Ctrl-C reaches every process of the terminal: the tests end what they started, and the driver only waits for them, as
its daemon and its guests are needed until then.  SIGTERM reaches the driver alone, and so it interrupts the tests.  A
command behind others has a session of its own, which neither reaches.
Either a second time, later, kills them.  Afterwards no command starts any more.
"""

import os
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from threading import Lock
from types import FrameType
from typing import Final, NamedTuple, TextIO

INTERRUPTED: Final = 130
"""Exit code of what SIGINT ended, as shells give it."""
ONE_INTERRUPTION_S = 1.0
"""Signals that come within this time are one: timeout(1) sends two, to its child and to the process group."""

BEHIND: Final = ("sh", "-c", '{ echo 10 > /proc/self/autogroup; } 2> /dev/null; exec nice -n 10 "$@"', "sh")
"""Runs a command with a tenth of the processors that others want, so that it never stands still.

Linux may share the processors among sessions first, and then a niceness has a meaning within a session only (sched(7)).
"""
LOOK_S: Final = 0.05
"""How often a command is looked at.  Python handles no signal that comes right before a call that blocks."""


class Ended(NamedTuple):
    code: int
    cpu_s: float
    """CPU time of the command with all processes that it waited for, in seconds."""


class Commands:
    """All commands that this program runs; threads may share it."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._running: set[int] = set()
        self._behind: set[int] = set()
        self._interrupted_at = 0.0
        self.is_interrupted = False

    def install(self) -> None:
        """Let Ctrl-C and SIGTERM end the commands instead of this program."""
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._on_signal)

    def run(
        self,
        command: Sequence[str],
        environment: Mapping[str, str],
        output: TextIO | None = None,
        *,
        is_behind: bool = False,
    ) -> Ended:
        """Run a command to its end, behind others if wanted; nothing after an interruption."""
        errors = None if output is None else subprocess.STDOUT
        with self._lock:
            if self.is_interrupted:
                return Ended(INTERRUPTED, 0.0)
            process = subprocess.Popen(
                [*BEHIND, *command] if is_behind else command,
                env=environment,
                stdout=output,
                stderr=errors,
                start_new_session=is_behind,
            )
            self._running.add(process.pid)
            if is_behind:
                self._behind.add(process.pid)
        while (ended := os.wait4(process.pid, os.WNOHANG))[0] == 0:
            time.sleep(LOOK_S)
        _, status, used = ended
        self._running.discard(process.pid)
        self._behind.discard(process.pid)
        process.returncode = os.waitstatus_to_exitcode(status)
        return Ended(process.returncode, used.ru_utime + used.ru_stime)

    def _on_signal(self, number: int, _frame: FrameType | None) -> None:
        is_first, now = not self.is_interrupted, time.monotonic()
        if is_first:
            self.is_interrupted, self._interrupted_at = True, now
        for pid in tuple(self._running):
            if is_first and (number == signal.SIGTERM or pid in self._behind):
                os.kill(pid, signal.SIGINT)
            elif now - self._interrupted_at > ONE_INTERRUPTION_S:
                os.kill(pid, signal.SIGKILL)
