"""Compiling programs for one controller: its host, with the libraries of blocks, panel and system, and its settings."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from fieldrig.clock import Clock
from fieldrig.errors import ConfigError, Mistake
from fieldrig.loop.background import Coarse
from fieldrig.real import progress
from fieldrig.text.source_text import decoded
from fieldrig_devices.hmiscu.plc.library import Instances, MakeBlock
from fieldrig_devices.hmiscu.settings import HmiscuSettings
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.controller.order import HostFacts, Order
from fieldrig_devices.iec.host import Library
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.refusal import refused
from fieldrig_devices.languages.source_file import SourceFile


class Compiler:
    """The compiler of one controller."""

    def __init__(
        self,
        clock: Clock,
        settings: HmiscuSettings,
        image: tuple[bytearray, bytearray],
        make: MakeBlock,
        instances: Mapping[str, str],
        libraries: Sequence[Library],
    ) -> None:
        """`image` has the areas %I and %Q, and `instances` the types of the global variables of the channels."""
        self._settings, self._names = settings, tuple(instances)
        self._instances = Instances(clock, make)
        self.host = StandaloneHost(clock)
        self.host.inputs, self.host.outputs = image
        self.host.libraries = (self._instances.library(instances), *libraries)

    def order(self, files: Sequence[SourceFile]) -> Order:
        """Return the order to compile these files in the dialect of the settings."""
        settings = self._settings
        return Order(tuple(files), settings.dialect, HostFacts.of(self.host), settings.resource, settings.costs)

    def compiled(self, files: Sequence[SourceFile]) -> Compiled:
        """Compile a program.  CompileError with every mistake."""
        return self.order(files).compiled(Coarse(progress.report))

    def configured(self) -> Compiled | None:
        """Compile the program of the rig file, if it names one.  ConfigError with every mistake."""
        paths = self._settings.program
        if not paths:
            return None
        try:
            return self.compiled([SourceFile(path.name, _text_of(path), path) for path in paths])
        except CompileError as wrong:
            raise refused(wrong, {path.name: str(path) for path in paths}) from wrong

    def connect(self, program: LoadedProgram) -> None:
        """Give the blocks of a program that has been loaded their channels."""
        self._instances.names = {program.runtime.find(name).steps[0]: name for name in self._names}


def _text_of(path: Path) -> str:
    """Return the text of a source file.  ConfigError if it cannot be read, or is too long."""
    try:
        return decoded(path.read_bytes())
    except (OSError, ValueError) as cause:
        raise ConfigError([Mistake(str(path), None, "program", str(cause), "expected a source file")]) from cause
