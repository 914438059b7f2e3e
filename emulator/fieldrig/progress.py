"""The steps of a process that starts, told to its supervisor through a pipe, a line for each.

The supervisor waits for a process that goes on from step to step, however long a busy host takes for all of them.  A
step is what the code has done (a module found, the rig file read, a hub open, a device built), never a guess from
processor time.  Without a pipe (a process that nobody supervises) nothing is told.
"""

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Final

LONGEST_STEP: Final = 200
"""Bytes, so that a step is written to the pipe in one piece."""

_pipes: list[int] = []


def report_to(pipe: int) -> None:
    """Tell the steps to the writing end of a pipe from now on; `step` never waits for the reader."""
    os.set_blocking(pipe, False)
    _pipes[:] = [pipe]


def step(text: str) -> None:
    """Tell that this has been reached."""
    for pipe in _pipes:
        with suppress(OSError):  # the pipe is full, which is progress enough, or its reader is gone
            os.write(pipe, text.replace("\n", " ").encode(errors="replace")[:LONGEST_STEP] + b"\n")


def finish() -> None:
    """The process is ready: there is nothing more to tell."""
    while _pipes:
        os.close(_pipes.pop())


class ImportSteps:
    """A finder for `sys.meta_path` that finds nothing: each module that is looked for is a step."""

    def find_spec(
        self, name: str, _path: Sequence[str] | None = None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        step(f"importing {name}")
        return None


def tell_imports() -> None:
    sys.meta_path.insert(0, ImportSteps())
