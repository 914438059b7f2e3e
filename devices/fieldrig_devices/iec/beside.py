"""The order to compile an IEC program beside its controller, with all that another process needs for it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NoReturn, Self

from fieldrig.loop.background import Report
from fieldrig_devices.iec.compiler import Compiled, compile_project
from fieldrig_devices.iec.costs import Costs
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.host import Host, Library, Pending
from fieldrig_devices.iec.layout import Layout
from fieldrig_devices.iec.program import ConfiguredObject
from fieldrig_devices.iec.types import ObjectType, Value
from fieldrig_devices.languages.beside import Refused, duration_of
from fieldrig_devices.languages.mistakes import CompileError
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

    files: tuple[SourceFile, ...]
    dialect: str
    """A key of `DIALECTS`."""
    facts: HostFacts
    previous: Layout | None = None
    """The layout of the running program, for an online change."""
    resource: str = ""
    """The RESOURCE that runs, if the program has several."""
    costs: Costs = field(default_factory=Costs)

    @property
    def duration_ns(self) -> int:
        """Virtual time that compiling takes."""
        return duration_of(file.text for file in self.files)


def compile_order(order: Order, report: Report) -> Compiled | Refused:
    """Compile a program in a process beside the controller."""
    try:
        return compile_project(
            order.files,
            order.facts,
            DIALECTS[order.dialect],
            previous=order.previous,
            costs=order.costs,
            resource=order.resource,
            on_progress=report,
        )
    except CompileError as wrong:
        return Refused(tuple(wrong.mistakes))
