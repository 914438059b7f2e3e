"""Compiling a stored program for the controller that it is stored on.

Source: PacDrive manual 6015-6041 (digest PD-310 to PD-318): RETAIN variables have to fit into the memory that the
controller has for them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, NoReturn, Self

from fieldrig.background import Report
from fieldrig_devices.iec.compiler import Compiled, compile_project
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.host import Host, Library, Pending
from fieldrig_devices.iec.limits import Limits
from fieldrig_devices.iec.program import ConfiguredObject
from fieldrig_devices.iec.types import ObjectType, Value
from fieldrig_devices.languages.mistakes import CompileError, Mistake
from fieldrig_devices.max4.configuration.program_file import Container
from fieldrig_devices.max4.plc.retain import RetainMap, leaves_of
from fieldrig_devices.max4.storage.retain import SIZES, RetainKind

NS_PER_CHARACTER: Final = 5_000
"""Virtual time that compiling takes, in nanoseconds."""


def _absent(*_inputs: Value) -> NoReturn:
    raise AssertionError("a function of the controller is not called while a program is compiled")


@dataclass(frozen=True, slots=True)
class HostFacts:
    """The facts about a host that a compiler needs; unlike the host itself, they can be sent to another process."""

    libraries: Sequence[Library]
    object_types: Mapping[str, ObjectType]
    objects: Mapping[str, ConfiguredObject]
    inputs: bytearray
    outputs: bytearray

    @classmethod
    def of(cls, host: Host) -> Self:
        libraries = tuple(
            Library(
                library.name,
                library.text,
                {name: replace(function, run=_absent) for name, function in library.functions.items()},
                {name: replace(block, run=_absent, forget=_nothing) for name, block in library.blocks.items()},
            )
            for library in host.libraries
        )
        return cls(libraries, dict(host.object_types), dict(host.objects), bytearray(), bytearray())

    def read(self, address: int) -> Value:
        _absent()

    def write(self, address: int, value: Value) -> None:
        _absent()

    def read_slowly(self, address: int) -> Pending:
        _absent()

    def write_slowly(self, address: int, value: Value) -> Pending:
        _absent()

    def on_output(self, byte: int) -> None:
        _absent()

    def now_ms(self) -> int:
        _absent()


def _nothing() -> None:
    """There is nothing to forget."""


@dataclass(frozen=True, slots=True)
class Order:
    """A program that is to be compiled."""

    container: Container
    facts: HostFacts
    retain: RetainKind
    limits: Limits
    previous: Compiled | None = None
    """The running program, for an online change."""

    @property
    def duration_ns(self) -> int:
        """Virtual time that compiling takes."""
        return NS_PER_CHARACTER * sum(len(source.text) for source in self.container.files)


@dataclass(frozen=True, slots=True)
class Refused:
    """A program that cannot be compiled."""

    mistakes: tuple[Mistake, ...]

    def __str__(self) -> str:
        return text_of(self.mistakes)


def compile_order(order: Order, report: Report) -> Compiled | Refused:
    """Compile a program in a process beside the controller."""
    try:
        return compile_container(order.container, order.facts, order.retain, order.limits, order.previous, report)
    except CompileError as wrong:
        return Refused(tuple(wrong.mistakes))


def compile_container(
    container: Container,
    host: Host,
    retain: RetainKind,
    limits: Limits,
    previous: Compiled | None = None,
    report: Report = lambda what, done, steps: None,
) -> Compiled:
    """Compile the sources; CompileError with all mistakes.  `previous` is the running program for an online change."""
    dialect = DIALECTS.get(container.dialect)
    if dialect is None:
        known = ", ".join(DIALECTS)
        raise CompileError([Mistake(1, 1, f"the dialect {container.dialect!r} is not known", known)])
    compiled = compile_project(container.files, host, dialect, limits=limits, previous=previous, on_progress=report)
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
            f"{variable.name} is at an address, and the controller keeps no area of inputs, outputs or markers",
            "a RETAIN variable without AT",
            file=variable.file,
        )
        for variable in variables
        if variable.is_retain and variable.location is not None
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


def text_of(mistakes: Sequence[Mistake]) -> str:
    """The mistakes, one a line, without notes."""
    return "\n".join(str(mistake) for mistake in mistakes if not mistake.is_note)
