"""Compiling programs for one controller.

Source: PacDrive manual 6015-6041 (digest PD-310 to PD-318): RETAIN variables have to fit into the memory that the
controller has for them.
"""

from dataclasses import replace
from functools import partial

from fieldrig.loop.background import Coarse
from fieldrig.real import progress
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.controller.order import HostFacts, Order
from fieldrig_devices.iec.host import Host
from fieldrig_devices.iec.program import Program, Variable
from fieldrig_devices.languages.mistakes import CompileError, Mistake
from fieldrig_devices.max4.configuration.limits import limits_of
from fieldrig_devices.max4.configuration.program_file import Container
from fieldrig_devices.max4.configuration.version import version_of
from fieldrig_devices.max4.plc.retain import RetainMap, leaves_of
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.max4.storage.retain import SIZES


class Compiler:
    """The compiler of one controller.  It keeps its last program, because most boots find the same one."""

    def __init__(self, settings: Max4Settings) -> None:
        self._costs, self._limits = settings.costs, limits_of(version_of(settings.version))
        self._check = partial(_check_retain, SIZES[settings.retain])
        self._last: tuple[Order, Compiled] | None = None

    def order(self, container: Container, host: Host) -> Order:
        facts = HostFacts.of(host)
        return Order(
            container.files, container.dialect, facts, container.resource, self._costs, self._limits, self._check
        )

    def compiled(self, order: Order) -> Compiled:
        """Compile a program, unless it is the last one, for the same objects.  CompileError with every mistake."""
        if self._last is None or self._last[0] != order:
            self.keep(order, order.compiled(Coarse(progress.report)))
        assert self._last is not None
        return self._last[1]

    def keep(self, order: Order, compiled: Compiled) -> None:
        """Keep a program that has been compiled elsewhere."""
        self._last = replace(order, previous=None), compiled


def _check_retain(size: int, compiled: Compiled) -> None:
    program = compiled.program
    variables = [
        *program.globals.values(),
        *(variable for pou in program.pous.values() for variable in pou.variables.values()),
    ]
    located = [
        Mistake(
            variable.position.line,
            variable.position.column,
            f"{variable.name} is at an address of %{area}, and no inputs or outputs are kept over power-off",
            "an address of %M for a RETAIN variable, or none",
            file=variable.file,
        )
        for variable in variables
        if variable.is_retain
        for area in sorted(_areas(variable, program) - {"M"})
    ]
    if located:
        raise CompileError(located)
    leaves = leaves_of(compiled.program)
    needed = RetainMap(leaves).size
    if needed <= size:
        return
    at = 0
    for leaf in leaves:
        at += leaf.size
        if at > size:
            break
    source = leaf.variable
    assert source is not None, "a leaf of a program belongs to a variable"
    raise CompileError(
        [
            Mistake(
                source.position.line,
                source.position.column,
                f"the RETAIN variables need {needed} bytes, and {leaf.path} is the first that has no room",
                f"at most {size} bytes",
                file=source.file,
                hint="Declare fewer variables as RETAIN, or give the controller more memory: "
                "`retain: ups` has 64 kB, `retain: pn4` 101 kB.",
            )
        ]
    )


def _areas(variable: Variable, program: Program) -> set[str]:
    """Return the areas that a variable has an address in; several if its instances have their own."""
    if variable.location is not None:
        return {variable.location.area}
    return {link.where.area for link in program.links if link.variable is variable}
