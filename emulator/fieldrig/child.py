"""One spawned process of a rig, and its log."""

import asyncio
import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path

from fieldrig.config import RigConfig
from fieldrig.exits import ABOUT, Exit
from fieldrig.placement import ProcessPlan

TAIL_LINES = 20


def command(config: RigConfig, plan: ProcessPlan, overrides: Sequence[str], is_realtime: bool) -> list[str]:
    """The command line of a host."""
    line = [sys.executable, "-m", "fieldrig.host", str(config.path), "--process", plan.name]
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
        self._process: asyncio.subprocess.Process | None = None

    @property
    def pid(self) -> int | None:
        return None if self._process is None else self._process.pid

    async def spawn(self) -> None:
        with self._log.open("wb" if self._process is None else "ab") as log:
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
        assert self._process is not None
        return await self._process.wait()

    def end(self, number: signal.Signals) -> None:
        if self._process is not None and self._process.returncode is None:
            self._process.send_signal(number)

    def tail(self) -> str:
        """The last lines that it wrote since it was spawned."""
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
