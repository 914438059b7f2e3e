"""Test files with the code that they judge, compiled to one program."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.compiler import Compiled, compile_project
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.limits import Limits
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.iec.testing.assertions import Assertion
from fieldrig_devices.iec.testing.extension import CaseBlock, CaseExtension
from fieldrig_devices.iec.testing.judge import Judge
from fieldrig_devices.iec.testing.mocks import Mock
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile

_MUCH: Final = 1 << 30
NO_LIMITS: Final = Limits(code=_MUCH, data=_MUCH, retain=_MUCH, variable=_MUCH, if_depth=1_000)
"""A test runs on no controller, so there are no limits of its memory."""


@dataclass(slots=True)
class Tested:
    """A compiled program with its tests, its clock and its judge."""

    compiled: Compiled
    blocks: Sequence[CaseBlock]
    assertions: Sequence[Assertion]
    mocks: Sequence[Mock]
    clock: VirtualClock
    host: StandaloneHost
    judge: Judge


def compile_tests(
    files: Sequence[SourceFile], dialect: Dialect, mocked: Sequence[str] = (), resource: str = ""
) -> Tested:
    """Compile test files with their code.  CompileError with all mistakes."""
    clock, judge, extension = VirtualClock(), Judge(), CaseExtension(mocked)
    host = StandaloneHost(clock)
    host.libraries = (judge.library,)
    mistakes = []
    try:
        compiled = compile_project(
            files, host, dialect, limits=NO_LIMITS, resource=resource, extension=extension, in_advance=False
        )
    except CompileError as wrong:
        mistakes = wrong.mistakes
    mistakes = [*mistakes, *extension.mistakes]
    if any(not mistake.is_note for mistake in mistakes):
        real = [mistake for mistake in mistakes if not mistake.is_note]
        raise CompileError(sorted(real, key=lambda mistake: (mistake.file, mistake.line, mistake.column)))
    if extension.mocks.unknown:
        names = ", ".join(extension.mocks.unknown)
        raise ValueError(f"there is nothing to mock: expected functions or blocks of the program, got {names}")
    return Tested(compiled, extension.blocks, extension.assertions, extension.mocks.by_number, clock, host, judge)
