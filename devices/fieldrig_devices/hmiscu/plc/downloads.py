"""Programs that arrive while the controller is on: downloads and online changes.

A program is compiled beside the running one.  One that is refused leaves the present one.
"""

import logging
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from fieldrig.clock import Clock
from fieldrig.loop.background import Background
from fieldrig_devices.hmiscu.settings import HmiscuSettings
from fieldrig_devices.iec.beside import HostFacts, Order, compile_order
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.layout import Layout
from fieldrig_devices.iec.loaded import LONGEST_WAIT_NS, NO_GAP
from fieldrig_devices.iec.task_points import task_forms
from fieldrig_devices.languages.beside import Beside
from fieldrig_devices.languages.source_file import SourceFile

if TYPE_CHECKING:
    from fieldrig_devices.hmiscu.plc.plc import Plc

log = logging.getLogger(__name__)


class Downloads:
    """The downloads and online changes of one controller."""

    def __init__(
        self,
        clock: Clock,
        background: Background,
        plc: "Plc",
        settings: HmiscuSettings,
        on_change: Callable[[], None],
    ) -> None:
        """`on_change` is called when an online change has happened."""
        self._clock, self._beside, self._plc = clock, Beside[Compiled](background), plc
        self._settings = settings
        self._on_change = on_change
        self._is_changing = False
        """True while a compiled program waits for the end of a cycle."""

    @property
    def progress(self) -> str:
        """The progress of a program that is not loaded yet; empty if there is none."""
        return "waiting for the end of a cycle" if self._is_changing else self._beside.progress

    def cancel(self) -> None:
        """Drop what is under way."""
        self._beside.cancel()
        self._is_changing = False

    def download(self, files: tuple[SourceFile, ...]) -> None:
        """Compile a program; then the controller goes to STOP, and loads it with its start values."""
        self._compile(files, None, self._plc.load)

    def change(self, files: tuple[SourceFile, ...]) -> None:
        """Change the running program at the end of a cycle; its variables keep their values.

        It is refused if some task is within a cycle at every instant of LONGEST_WAIT_NS.  ValueError if there is no
        program.
        """
        program = self._plc.program
        if program is None:
            raise ValueError("an online change needs a program in the controller: expected a download first")

        def load(compiled: Compiled) -> None:
            if self._plc.program is not program:
                self._refuse("the program has ended before its change")
            elif task_forms(compiled) != task_forms(program.compiled):
                self._refuse("the task configuration has changed: expected a download, which stops the program")
            else:
                self._is_changing = True
                withdraw = program.change(compiled, self._changed)
                if self._is_changing:
                    self._clock.call_at(self._clock.now_ns() + LONGEST_WAIT_NS, partial(self._give_up, withdraw))

        self._compile(files, program.compiled.layout, load)

    def _give_up(self, withdraw: Callable[[], bool]) -> None:
        if withdraw():
            self._is_changing = False
            self._refuse(NO_GAP)

    def _changed(self) -> None:
        self._is_changing = False
        self._on_change()

    def _compile(
        self, files: tuple[SourceFile, ...], previous: Layout | None, load: Callable[[Compiled], None]
    ) -> None:
        settings, facts = self._settings, HostFacts.of(self._plc.host)
        order = Order(files, settings.dialect, facts, previous, settings.resource, settings.costs)

        def on_done(found: Compiled | str) -> None:
            if isinstance(found, Compiled):
                load(found)
            else:
                self._refuse(found)

        self._beside.compile(compile_order, order, order.duration_ns, on_done)

    def _refuse(self, problem: str) -> None:
        self._plc.problem = problem
        log.warning("the program was refused: %s", problem)
