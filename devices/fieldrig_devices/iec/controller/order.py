"""The order to compile an IEC program for a controller, with all that another process needs for it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NoReturn, Self

from fieldrig.loop.background import Report
from fieldrig_devices.iec.compiler import Compiled, compile_project
from fieldrig_devices.iec.costs import Costs
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.host import Host, Library, Pending
from fieldrig_devices.iec.layout import Layout
from fieldrig_devices.iec.limits import MAX_4, Limits
from fieldrig_devices.iec.program import ConfiguredObject
from fieldrig_devices.iec.types import ObjectType, Value
from fieldrig_devices.languages.beside import Refused, duration_of
from fieldrig_devices.languages.mistakes import CompileError, Mistake
from fieldrig_devices.languages.source_file import SourceFile


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
            replace(
                library,
                functions={name: replace(function, run=_absent) for name, function in library.functions.items()},
                blocks={name: replace(block, run=_absent, forget=_nothing) for name, block in library.blocks.items()},
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


def _accept(_compiled: Compiled) -> None:
    """Every program that compiles can run."""


@dataclass(frozen=True, slots=True)
class Order:
    """A program that is to be compiled for a controller."""

    files: tuple[SourceFile, ...]
    dialect: str
    """A key of `DIALECTS`; a stored program may name one that is not known any more."""
    host: Host
    """The controller; `HostFacts` for another process."""
    resource: str = ""
    """The RESOURCE that runs, if the program has several."""
    costs: Costs = field(default_factory=Costs)
    limits: Limits = MAX_4
    # A function with its arguments, and no method of the controller: the order is sent to another process.
    check: Callable[[Compiled], None] = _accept
    """Raises CompileError for a program that this controller cannot run."""
    previous: Layout | None = None
    """The layout of the running program, for an online change."""

    @property
    def duration_ns(self) -> int:
        """Virtual time that compiling takes."""
        return duration_of(file.text for file in self.files)

    def compiled(self, report: Report = lambda what, done, steps: None) -> Compiled:
        """Compile the program.  CompileError with every mistake."""
        dialect = DIALECTS.get(self.dialect)
        if dialect is None:
            raise CompileError([Mistake(1, 1, f"the dialect {self.dialect!r} is not known", ", ".join(DIALECTS))])
        compiled = compile_project(
            self.files,
            self.host,
            dialect,
            limits=self.limits,
            previous=self.previous,
            costs=self.costs,
            resource=self.resource,
            on_progress=report,
        )
        self.check(compiled)
        return compiled


def compile_order(order: Order, report: Report) -> Compiled | Refused:
    """Compile a program in a process beside the controller."""
    try:
        return order.compiled(report)
    except CompileError as wrong:
        return Refused(tuple(wrong.mistakes))
