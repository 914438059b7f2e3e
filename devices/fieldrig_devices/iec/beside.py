"""Compiling a program beside the controller that it is for, in a process of its own.

In virtual time the result comes after a time that depends on the length of the sources.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, NoReturn, Self

from fieldrig.background import Background, Failure, Job, Report
from fieldrig_devices.iec.compiler import Compiled, compile_project
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.host import Host, Library, Pending
from fieldrig_devices.iec.program import ConfiguredObject
from fieldrig_devices.iec.types import ObjectType, Value
from fieldrig_devices.languages.mistakes import CompileError, Mistake
from fieldrig_devices.languages.source_file import SourceFile

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
class Refused:
    """A program that cannot be compiled."""

    mistakes: tuple[Mistake, ...]

    def __str__(self) -> str:
        return text_of(self.mistakes)


def text_of(mistakes: Sequence[Mistake]) -> str:
    """The mistakes, one a line, without notes."""
    return "\n".join(str(mistake) for mistake in mistakes if not mistake.is_note)


@dataclass(frozen=True, slots=True)
class Order:
    """A program that is to be compiled."""

    files: tuple[SourceFile, ...]
    dialect: str
    """A key of `DIALECTS`."""
    facts: HostFacts
    previous: Compiled | None = None
    """The running program, for an online change."""

    @property
    def duration_ns(self) -> int:
        """Virtual time that compiling takes."""
        return duration_of(file.text for file in self.files)


def duration_of(texts: Iterable[str]) -> int:
    """Virtual time that compiling these texts takes, in nanoseconds."""
    return NS_PER_CHARACTER * sum(map(len, texts))


def compile_order(order: Order, report: Report) -> Compiled | Refused:
    """Compile a program in a process beside the controller."""
    try:
        return compile_project(
            order.files, order.facts, DIALECTS[order.dialect], previous=order.previous, on_progress=report
        )
    except CompileError as wrong:
        return Refused(tuple(wrong.mistakes))


class Beside:
    """The compiler of one controller, which compiles one program at a time; a new one takes the place of the last."""

    def __init__(self, background: Background) -> None:
        self._background = background
        self._job: Job | None = None
        self.progress = ""
        """How far the compiler is; empty if there is nothing to do."""

    def compile(
        self,
        work: Callable[[Any, Report], Compiled | Refused],
        order: Any,
        duration_ns: int,
        on_done: Callable[[Compiled | str], None],
    ) -> None:
        """Call `work(order, report)` beside the controller, and `on_done` with a program, or why there is none."""

        def on_found(found: Compiled | Refused | Failure) -> None:
            self._job, self.progress = None, ""
            on_done(found if isinstance(found, Compiled) else found.why if isinstance(found, Failure) else str(found))

        def on_progress(what: str, done: int, steps: int) -> None:
            self.progress = f"{what} {100 * done // max(steps, 1)} %"

        self.cancel()
        self.progress = "compiling 0 %"
        self._job = self._background.run(work, order, on_found, on_progress, virtual_ns=duration_ns)

    def cancel(self) -> None:
        """Drop what is being compiled."""
        if self._job is not None:
            self._job.cancel()
        self._job, self.progress = None, ""
