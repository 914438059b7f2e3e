"""Programs that arrive while a controller is on: downloads and online changes.

A program is compiled beside the running one.  One that is refused leaves the present one.  What an online change cannot
do is what CoDeSys V2.3 refuses: a changed task configuration.
"""

import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Final, Protocol

from fieldrig.clock import MS, Alarm, Clock
from fieldrig.loop.background import Background
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.controller.order import Order, compile_order
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.languages.beside import Beside

log = logging.getLogger(__name__)

LONGEST_WAIT_NS: Final = 10_000 * MS
"""How long an online change waits for an instant at which no task is within a cycle; the manual gives no limit."""
NO_GAP: Final = (
    f"some task was within a cycle at every instant of {LONGEST_WAIT_NS // (1_000 * MS)} s: "
    "expected less load, no task at a breakpoint, or a download"
)

OnDone = Callable[[str], None]
"""Called with an empty text when a program has been loaded, or with the reason, such as its mistakes, if it has not."""


class Plc(Protocol):
    """A controller that takes programs."""

    @property
    def program(self) -> LoadedProgram | None: ...

    def load(self, order: Order, compiled: Compiled) -> None:
        """Take a program with its start values, instead of the present one."""

    def on_changed(self, order: Order, compiled: Compiled) -> None:
        """Called when the running program has been changed; its variables have kept their values."""

    def on_refused(self, problem: str) -> None:
        """Called when a program has been refused, which leaves the present one."""


def _nothing(_problem: str) -> None:
    """The result is not needed."""


class Downloads:
    """The downloads and online changes of one controller."""

    def __init__(self, clock: Clock, background: Background, plc: Plc) -> None:
        self._plc, self._beside = plc, Beside[Compiled](background)
        self._wait = Alarm(clock)
        """Set while a compiled program waits for the end of a cycle."""
        self._withdraw: Callable[[], bool] = lambda: False
        """Withdraws the change that waits; false if that is too late."""

    @property
    def progress(self) -> str:
        """The progress of a program that is not loaded yet; empty if there is none."""
        return "waiting for the end of a cycle" if self._wait.is_set else self._beside.progress

    def cancel(self) -> None:
        """Drop what is under way."""
        self._beside.cancel()
        if self._wait.is_set:
            self._wait.stop()
            self._withdraw()

    def download(self, order: Order, on_done: OnDone = _nothing) -> None:
        """Compile a program; then stop the present one, and load this with its start values."""

        def load(compiled: Compiled) -> None:
            self.cancel()  # a change that waits for the program that ends now
            self._plc.load(order, compiled)
            on_done("")

        self._compile(order, load, on_done)

    def change(self, order: Order, on_done: OnDone = _nothing) -> None:
        """Change the running program at the end of a cycle; its variables keep their values (PD-225).

        It is refused if some task is within a cycle at every instant of LONGEST_WAIT_NS.  ValueError if there is no
        program.
        """
        program = self._plc.program
        if program is None:
            raise ValueError("an online change needs a program in the controller: expected a download first")
        order = replace(order, previous=program.compiled.layout)

        def load(compiled: Compiled) -> None:
            if self._plc.program is not program:
                self._refuse("the program has ended before its change", on_done)
            elif task_forms(compiled) != task_forms(program.compiled):
                self._refuse(
                    "the task configuration has changed: expected a download, which stops the program", on_done
                )
            else:
                self._change(program, order, compiled, on_done)

        self._compile(order, load, on_done)

    def exchange(self, order: Order) -> None:
        """Go on with another program at this instant, as if the controller had had it before; for tests of programs.

        No task may be within a cycle.  CompileError with every mistake, which leaves the present program.
        """
        program = self._plc.program
        assert program is not None, "there is a program to exchange"
        assert program.scheduler.is_quiet, "no task is within a cycle"
        compiled = replace(order, previous=program.compiled.layout).compiled()
        program.change(compiled, partial(self._plc.on_changed, order, compiled))

    def _change(self, program: LoadedProgram, order: Order, compiled: Compiled, on_done: OnDone) -> None:
        def on_changed() -> None:
            self._wait.stop()
            self._plc.on_changed(order, compiled)
            on_done("")

        def give_up() -> None:
            if self._withdraw():
                self._refuse(NO_GAP, on_done)

        self.cancel()
        # The time begins before the change, which may happen at once and then ends it.
        self._wait.after(LONGEST_WAIT_NS, give_up)
        self._withdraw = program.change(compiled, on_changed)

    def _compile(self, order: Order, load: Callable[[Compiled], None], on_done: OnDone) -> None:
        def on_compiled(result: Compiled | str) -> None:
            if isinstance(result, Compiled):
                load(result)
            else:
                self._refuse(result, on_done)

        self._beside.compile(compile_order, order, order.duration_ns, on_compiled)

    def _refuse(self, problem: str, on_done: OnDone) -> None:
        log.warning("the program was refused: %s", problem)
        self._plc.on_refused(problem)
        on_done(problem)


def task_forms(compiled: Compiled) -> list[Mapping[str, object]]:
    """The task configuration, which an online change must leave as it is."""
    return [
        {
            "name": task.name.casefold(),
            "kind": task.kind,
            "priority": task.priority,
            "interval": task.interval_ms,
            "event": task.event.name.casefold() if task.event is not None else "",
            "programs": [pou.name.casefold() for pou in task.programs],
        }
        for task in compiled.program.tasks
    ]
