"""A scenario with a master: a program of Python, unchanged, that acts on the rig in its virtual time.

The master begins with the scenario, in a thread of its own (`fieldrig.master_time.program`).  Time passes only while it
waits, and the stage waits beside it from look to look, so both see each instant.
"""

from typing import Final

from fieldrig.master_time.errors import VirtualTimeError
from fieldrig.master_time.program import wait_until
from fieldrig_devices.scenarios.play import LOOK_NS, Stage
from fieldrig_devices.scenarios.property import Violation

GOES_ON: Final = "the master stays in virtual time"
"""The property of every scenario with a master: it waits now and then, and for nothing outside of the rig."""


class MasterStage(Stage):
    """A stage with a master, used within `fieldrig.master_time.program.mastered`."""

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
            if self._takes_reached():
                return
            self._heal()
