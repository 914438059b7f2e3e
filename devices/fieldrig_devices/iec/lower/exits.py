"""Ways out of a body: RETURN, EXIT and CONTINUE run the __FINALLY of each __TRY that they leave.

The statements of a __FINALLY are in the code once.  Each way to them puts the number of the way behind them
into a cell: 0 for the end of the __TRY, 1 for a fault that goes on, and one for each place that is left for.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Final

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.lower.assembler import Label
from fieldrig_devices.iec.lower.body import Body
from fieldrig_devices.iec.program import Cell, Constant, Load

THROUGH: Final = 0
AGAIN: Final = 1


@dataclass(slots=True)
class Cleanup:
    """The __FINALLY of a __TRY that is being lowered."""

    label: Label
    way: Cell
    """The number of the way behind it."""
    loops: int
    """The loops around the __TRY."""
    targets: list[Label | None] = field(default_factory=list)
    """The ends of the ways from 2 on; None is the end of the body."""

    def way_to(self, target: Label | None) -> int:
        if target not in self.targets:
            self.targets.append(target)
        return AGAIN + 1 + self.targets.index(target)


class Exits:
    """The ends of EXIT, CONTINUE and RETURN."""

    def __init__(self, body: Body) -> None:
        self._body, self._assembler = body, body.assembler
        self.loops: list[tuple[Label, Label]] = []
        """Labels that CONTINUE and EXIT jump to."""
        self._cleanups: list[Cleanup] = []

    def out_of_loop(self) -> None:
        self._leave(self.loops[-1][1], len(self.loops) - 1)

    def next_pass(self) -> None:
        self._leave(self.loops[-1][0], len(self.loops) - 1)

    def out_of_body(self) -> None:
        self._leave(None, -1)

    def _leave(self, target: Label | None, loop: int) -> None:
        """Go to a label of the loop with this number, or to the end of the body, through each __FINALLY between."""
        cleanup = self._cleanups[-1] if self._cleanups else None
        if cleanup is not None and loop < cleanup.loops:
            self._set(cleanup.way, cleanup.way_to(target))
            self._assembler.jump(cleanup.label)
        elif target is None:
            self._assembler.end()
        else:
            self._assembler.jump(target)

    def guarded(
        self, add: Callable[[], None], caught: Callable[[], None] | None, final: Callable[[], None] | None, fault: Cell
    ) -> None:
        """Add a body with what runs after a fault in it, and what runs behind both in any case.

        The number of the fault is in `fault`.
        """
        handler, end = self._assembler.labels(2)
        cleanup = None
        if final is not None:
            way = Cell(self._body.held(Elementary.DINT), Elementary.DINT)
            cleanup = Cleanup(self._assembler.label(), way, len(self.loops))
            self._set(way, THROUGH)
            self._cleanups.append(cleanup)
        behind = end if cleanup is None else cleanup.label
        again = self._assembler.label()
        self._assembler.guard(add, handler if caught is not None else again, fault.variable.offset)
        self._assembler.jump(behind)
        if caught is not None:
            self._assembler.place(handler)
            self._guard_handler(caught, again, fault, cleanup)
        if cleanup is not None and final is not None:
            self._finish(cleanup, final, again, fault)
        self._assembler.place(end)

    def _guard_handler(self, caught: Callable[[], None], again: Label, fault: Cell, cleanup: Cleanup | None) -> None:
        """Add what runs after a fault; a fault in it goes on, behind the __FINALLY if there is one."""
        if cleanup is None:
            caught()
            return
        self._assembler.guard(caught, again, fault.variable.offset)
        self._assembler.jump(cleanup.label)

    def _finish(self, cleanup: Cleanup, final: Callable[[], None], again: Label, fault: Cell) -> None:
        self._assembler.place(again)
        self._set(cleanup.way, AGAIN)
        self._cleanups.pop()
        self._assembler.place(cleanup.label)
        final()
        self._unless(cleanup.way, AGAIN, lambda: self._throw(fault))
        for target in cleanup.targets:
            loop = next((n for n, labels in enumerate(self.loops) if target in labels), -1)
            self._unless(cleanup.way, cleanup.way_to(target), partial(self._leave, target, loop))

    def _unless(self, way: Cell, number: int, add: Callable[[], None]) -> None:
        """Add code for one way."""
        other = self._assembler.label()
        emitter = self._body.emitter()
        value = self._body.expressions.value(Load(way), emitter)
        self._assembler.branch(emitter, f"{value.text} != {number}", other)
        add()
        self._assembler.place(other)

    def _throw(self, fault: Cell) -> None:
        emitter = self._body.emitter()
        emitter.add(f"thrown({self._body.expressions.value(Load(fault), emitter).text})")
        self._body.do(emitter)

    def _set(self, way: Cell, number: int) -> None:
        self._body.store(way, Constant(number, Elementary.DINT))
