"""The steps of a starting process, reported to its supervisor through a pipe, one line each.

The supervisor waits for a process that reports step after step, however long all of them take on a busy host.  A step
is something the code has done (a module found, the rig file read, a hub opened, a device built), not an estimate from
processor time.  Without a pipe (in a process without a supervisor) nothing is reported.
"""

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Final

LONGEST_STEP: Final = 200
"""Longest step in bytes, so that it is written to the pipe in one piece."""
READY: Final = "ready"
"""The last step."""

_pipes: list[int] = []


def report_to(pipe: int) -> None:
    """Report the steps to the writing end of a pipe from now on; `step` never waits for the reader."""
    if hasattr(os, "set_blocking"):
        os.set_blocking(pipe, False)
    _pipes[:] = [pipe]


def step(text: str) -> None:
    """Report that this step has been reached."""
    for pipe in _pipes:
        with suppress(OSError):  # the pipe is full, which is progress enough, or its reader is gone
            os.write(pipe, text.replace("\n", " ").encode(errors="replace")[:LONGEST_STEP] + b"\n")


def report(what: str, done: int, steps: int) -> None:
    """Report a part of a long step, such as compiling a stored program, as `background.Report` says."""
    step(f"{what} {100 * done // max(steps, 1)} %")


def finish() -> None:
    """Stop reporting, as the process is ready."""
    while _pipes:
        os.close(_pipes.pop())


class ImportSteps:
    """A finder for `sys.meta_path` that finds nothing, but reports each module that is looked for as a step."""

    def find_spec(
        self, name: str, _path: Sequence[str] | None = None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        step(f"importing {name}")
        return None


def report_imports() -> None:
    sys.meta_path.insert(0, ImportSteps())
