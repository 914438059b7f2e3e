"""Compiling a stored program for the controller that it is stored on.

Source: PacDrive manual 6015-6041 (digest PD-310 to PD-318): RETAIN variables have to fit into the memory that the
controller has for them.
"""

from dataclasses import dataclass, field

from fieldrig.loop.background import Report
from fieldrig_devices.iec.beside import HostFacts
from fieldrig_devices.iec.compiler import Compiled, compile_project
from fieldrig_devices.iec.costs import Costs
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.host import Host
from fieldrig_devices.iec.layout import Layout
from fieldrig_devices.iec.limits import Limits
from fieldrig_devices.iec.program import Program, Variable
from fieldrig_devices.languages.beside import Refused, duration_of
from fieldrig_devices.languages.mistakes import CompileError, Mistake
from fieldrig_devices.max4.configuration.program_file import Container
from fieldrig_devices.max4.plc.retain import RetainMap, leaves_of
from fieldrig_devices.max4.storage.retain import SIZES, RetainKind


@dataclass(frozen=True, slots=True)
class Order:
    """A program that is to be compiled."""

    container: Container
    facts: HostFacts
    retain: RetainKind
    limits: Limits
    previous: Layout | None = None
    """The layout of the running program, for an online change."""
    costs: Costs = field(default_factory=Costs)

    @property
    def duration_ns(self) -> int:
        """Virtual time that compiling takes."""
        return duration_of(source.text for source in self.container.files)


def compile_order(order: Order, report: Report) -> Compiled | Refused:
    """Compile a program in a process beside the controller."""
    try:
        return compile_container(
            order.container, order.facts, order.retain, order.limits, order.previous, report, costs=order.costs
        )
    except CompileError as wrong:
        return Refused(tuple(wrong.mistakes))


def compile_container(
    container: Container,
    host: Host,
    retain: RetainKind,
    limits: Limits,
    previous: Layout | None = None,
    report: Report = lambda what, done, steps: None,
    *,
    costs: Costs | None = None,
) -> Compiled:
    """Compile the sources; CompileError with all mistakes.  `previous` is the layout of the running program for an
    online change."""
    dialect = DIALECTS.get(container.dialect)
    if dialect is None:
        known = ", ".join(DIALECTS)
        raise CompileError([Mistake(1, 1, f"the dialect {container.dialect!r} is not known", known)])
    compiled = compile_project(
        container.files,
        host,
        dialect,
        limits=limits,
        previous=previous,
        costs=costs,
        resource=container.resource,
        on_progress=report,
    )
    _check_retain(compiled, SIZES[retain])
    return compiled


def _check_retain(compiled: Compiled, size: int) -> None:
    program = compiled.program
    variables = [
        *program.globals.values(),
        *(variable for pou in program.pous.values() for variable in pou.variables.values()),
    ]
    located = [
        Mistake(
            variable.place.line,
            variable.place.column,
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
                source.place.line,
                source.place.column,
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
