"""A program of Python as a master beside other work in the virtual time of a rig, such as that of a scenario."""

import ast
import io
import runpy
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, redirect_stdout, suppress
from importlib import import_module
from pathlib import Path
from traceback import extract_tb
from typing import Final, NamedTuple

from fieldrig.clock import S
from fieldrig.master_time.block import virtual_time
from fieldrig.master_time.errors import EndedError, VirtualTimeError
from fieldrig.virtual.rig import Rig

PATIENCE_S: Final = 20.0
"""Processor time for which a master may compute without waiting."""


class Failed(NamedTuple):
    """The end of a program that would have an exit code other than 0."""

    at_ns: int
    what: str


class Master:
    """A program that acts as a master."""

    failed: Failed | None = None


def wait_until(rig: Rig, ns: int) -> None:
    """Let time pass up to an instant, as the master does.  VirtualTimeError if the master has left virtual time."""
    time.sleep((ns - rig.now_ns) / S)


@contextmanager
def mastered(rig: Rig, file: Path, jitter_ns: int, *, is_quiet: bool = False) -> Iterator[Master]:
    """Have a program of Python as the master of a rig meanwhile; `is_quiet` keeps what it prints to itself.

    Its wake-ups are late by up to `jitter_ns`, by chance from the seed of the rig; those of the stage are not.
    """
    master, jitter_s = Master(), jitter_ns / S
    with suppress(VirtualTimeError):  # the stage has noted it, or the master does not end, which is no concern here
        silence = redirect_stdout(io.StringIO()) if is_quiet else nullcontext()
        block = virtual_time(rig, jitter=jitter_s, seed=rig.config.seed, patience_s=PATIENCE_S, is_main_punctual=True)
        with silence, block:
            with suppress(VirtualTimeError):  # the next wait of the stage raises it as well
                threading.Thread(target=_play, args=(rig, file, master), name="master").start()
            yield master


def load_libraries(file: Path) -> None:
    """Import what a program imports, once for all branches; what cannot be imported is its own matter."""
    with suppress(OSError, SyntaxError):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) and node.module and not node.level else []
            for name in names:
                with suppress(Exception):
                    import_module(name)


def _play(rig: Rig, file: Path, master: Master) -> None:
    """Run the program; it may end whenever it likes, as the machine goes on without it."""
    sys.argv = [str(file)]
    sys.path.insert(0, str(file.resolve().parent))
    try:
        runpy.run_path(str(file), run_name="__main__")
    except EndedError:  # the end of the block
        raise
    except SystemExit as end:
        if end.code not in (None, 0):
            master.failed = Failed(rig.now_ns, f"it ends with the exit code {end.code}")
    except Exception as wrong:  # noqa: BLE001  the program is the user's
        master.failed = Failed(rig.now_ns, f"{type(wrong).__name__}: {wrong}{_line(wrong, file)}")


def _line(wrong: Exception, file: Path) -> str:
    """Return the line of a program that has raised an exception, or has called what raised it."""
    lines = [frame for frame in extract_tb(wrong.__traceback__) if frame.filename == str(file)]
    return f" ({file.name}:{lines[-1].lineno} in {lines[-1].name})" if lines else ""
