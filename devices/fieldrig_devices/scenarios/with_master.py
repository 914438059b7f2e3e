"""A scenario with a master: a program of Python, unchanged, that acts on the rig in its virtual time.

The master begins with the scenario, in a thread of its own (`fieldrig.master_time.program`).  Time passes only while it
waits, and the stage waits beside it from look to look, so both see each instant.  A master that fails is a violation at
the instant of its end; the rest of the scenario is judged as well, because the machine goes on without it.
"""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Final

from fieldrig.master_time.errors import VirtualTimeError
from fieldrig.master_time.program import Master, mastered, wait_until
from fieldrig_devices.scenarios.guard import MASTER_WORKS
from fieldrig_devices.scenarios.play import LOOK_NS, Stage
from fieldrig_devices.scenarios.property import Violation

GOES_ON: Final = "the master stays in virtual time"
"""The property of every scenario with a master: it waits now and then, and for nothing outside of the rig."""


class MasterStage(Stage):
    """A stage with a master, used within `acting`."""

    _master: Master | None = None
    _is_told = False

    @contextmanager
    def acting(self, file: Path, jitter_ns: int, *, is_quiet: bool = False) -> Iterator[None]:
        """Have a program act meanwhile, with the options of `mastered`."""
        with mastered(self._rig, file, jitter_ns, is_quiet=is_quiet) as self._master:
            yield

    def _never_stuck(self) -> AbstractContextManager[None]:
        return nullcontext()  # the block of the master sees to it

    def _run(self, until_ns: int) -> None:
        end_ns = self._begin_ns + until_ns
        while self._rig.now_ns < end_ns and not self.is_over:
            look_ns = min(end_ns, self._begin_ns + (self.now_ns // LOOK_NS + 1) * LOOK_NS)
            try:
                wait_until(self._rig, look_ns)
            except VirtualTimeError as wrong:
                self._seen.raised(Violation(GOES_ON, self.now_ns, wrong.what, ()))
                return
            self._on_instant()
            self._look_at_master()
            if self._takes_reached():
                return
            self._heal()

    def _look_at_master(self) -> None:
        failed = None if self._master is None else self._master.failed
        if failed is not None and not self._is_told:
            self._is_told = True
            self._seen.note(Violation(MASTER_WORKS, failed.at_ns - self._begin_ns, failed.what, ()))
            self._note_hash()
