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

from fieldrig.clock import S
from fieldrig.master_time.block import virtual_time
from fieldrig.master_time.errors import VirtualTimeError
from fieldrig.virtual.rig import Rig


def wait_until(rig: Rig, ns: int) -> None:
    """Let time pass up to an instant, as the master does.  VirtualTimeError if the master has left virtual time."""
    time.sleep((ns - rig.now_ns) / S)


@contextmanager
def mastered(rig: Rig, file: Path, jitter_ns: int, *, is_quiet: bool = False) -> Iterator[None]:
    """Have a program of Python as the master of a rig meanwhile; `is_quiet` keeps what it prints to itself.

    Its wake-ups are late by up to `jitter_ns`, by chance from the seed of the rig; those of the stage are not.
    """
    with suppress(VirtualTimeError):  # the stage has noted it, or the master does not end, which is no concern here
        silence = redirect_stdout(io.StringIO()) if is_quiet else nullcontext()
        with silence, virtual_time(rig, jitter=jitter_ns / S, seed=rig.config.seed, is_main_punctual=True):
            with suppress(VirtualTimeError):  # the next wait of the stage raises it as well
                threading.Thread(target=_play, args=(file,), name="master").start()
            yield


def load_libraries(file: Path) -> None:
    """Import what a program imports, once for all branches; what cannot be imported is its own matter."""
    with suppress(OSError, SyntaxError):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) and node.module and not node.level else []
            for name in names:
                with suppress(Exception):
                    import_module(name)


def _play(file: Path) -> None:
    """Run the program; it may end whenever it likes, also with an exception, as the machine goes on without it."""
    sys.argv = [str(file)]
    sys.path.insert(0, str(file.resolve().parent))
    with suppress(Exception):
        runpy.run_path(str(file), run_name="__main__")
