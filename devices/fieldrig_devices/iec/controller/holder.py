"""A device that runs IEC programs, as tools see it that check a program for it."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.languages.source_file import SourceFile


@runtime_checkable
class ProgramHolder(Protocol):
    def compile_sources(self, files: Sequence[SourceFile]) -> Compiled:
        """Compile a program for this device, with its objects and libraries, but do not load it.

        CompileError with every mistake.
        """

    @classmethod
    def without_program(cls) -> Sequence[str]:
        """Return changes of a rig file, `key=value`, that leave out the program and the settings that refer to it."""
