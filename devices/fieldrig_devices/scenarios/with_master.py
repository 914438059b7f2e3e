"""A scenario with a master: a program of Python, unchanged, that acts on the rig in its virtual time.

The master begins with the scenario, in a thread of its own.  Time passes only while it waits, and the stage waits
beside it from action to action, so both see each instant.
"""

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
from typing import TYPE_CHECKING, Final

from fieldrig.clock import S
from fieldrig.master_time.block import virtual_time
from fieldrig.master_time.errors import VirtualTimeError
from fieldrig_devices.scenarios.play import LOOK_NS, Stage
from fieldrig_devices.scenarios.property import Violation

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

GOES_ON: Final = "the master stays in virtual time"
"""The property of every scenario with a master: it waits now and then, and for nothing outside of the rig."""


class MasterStage(Stage):
    """A stage with a master, used within `mastered`."""

    def _run(self, until_ns: int) -> None:
        end_ns = self._begin_ns + until_ns
        while self._rig.now_ns < end_ns and not self.is_over:
            look_ns = min(end_ns, self._begin_ns + (self.now_ns // LOOK_NS + 1) * LOOK_NS)
            try:
                time.sleep((look_ns - self._rig.now_ns) / S)
            except VirtualTimeError as wrong:
                self._seen.raised(Violation(GOES_ON, self.now_ns, wrong.what, ()))
                return
            self._on_instant()
            if self._takes_reached():
                return
            self._heal()


@contextmanager
def mastered(rig: "Rig", file: Path, jitter_ns: int, *, is_quiet: bool = False) -> Iterator[None]:
    """Have a program of Python as the master of a rig meanwhile; `is_quiet` keeps what it prints to itself.

    Its wake-ups are late by up to `jitter_ns`, by chance from the seed of the rig; those of the stage are not.
    """
    with suppress(VirtualTimeError):  # the stage has noted it, or the master does not end, which is no concern here
        silence = redirect_stdout(io.StringIO()) if is_quiet else nullcontext()
        punctual = {"is_main_punctual": True}
        with silence, virtual_time(rig, jitter=jitter_ns / S, seed=rig.config.seed, **punctual):
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
