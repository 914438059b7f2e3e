"""The files of a project on the flash disk: configuration, start values, program.

Source: PacDrive manual 3636-3648, 4099-4105 (digest PD-026, PD-027, PD-043).  The project of the rig file is installed
whenever the rig file has changed, like a download at the desk; other changes of the files stay.
"""

import hashlib
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from fieldrig.device import Value
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.configuration.files import (
    Configuration,
    configuration_of_file,
    configuration_to_file,
    parameters_of_file,
    parameters_to_file,
)
from fieldrig_devices.max4.configuration.program_file import PROGRAM_FILE, Container, source_of
from fieldrig_devices.max4.settings import Max4Settings, disk_name
from fieldrig_devices.max4.storage.disk import FlashDisk, file_name

CAN_MASTER_FILE: Final = "\\CANMA.CON"
BUS_FILES: Final = (CAN_MASTER_FILE, "\\CANSL.CON", "\\PROFIMA.CON", "\\PROFISL.CON")
_INSTALLED: Final = "$SETTINGS"


class Loaded(NamedTuple):
    """The content of the files at a boot."""

    configuration: Configuration
    values: Mapping[str, Value]
    is_good: bool
    """True if the files could be read; otherwise this is an empty project."""


class Project:
    """The project of one controller."""

    def __init__(self, settings: Max4Settings, disk: FlashDisk) -> None:
        self._settings, self._disk = settings, disk
        self.configuration_file = f"\\{settings.project}.SCF"
        self.parameter_file = f"\\{settings.project}.PAR"

    def install(self, values: Mapping[str, Value], pages: Mapping[str, bytes]) -> bool:
        """Install the project of the rig file if it has changed; `values` are all start values.

        `pages` are files that are installed with it, except where it has one of the same name.

        Return true if its program has changed, so that the variables begin with their start values.
        """
        settings = self._settings
        sources = self.sources()
        program = None if sources is None else sources.encode()
        wanted = settings.configuration.model_dump_json() + repr(sorted(settings.parameters.items())) + settings.project
        further = {**pages, **{disk_name(path): path.read_bytes() for path in settings.files}}
        if further:
            wanted += repr(sorted(further.items()))
        mark = hashlib.sha256(wanted.encode() + (program or b"")).digest()
        if self._disk.hidden(_INSTALLED) == mark:
            return False
        before = self.program
        files = {
            **further,
            self.configuration_file: configuration_to_file(settings.configuration),
            self.parameter_file: parameters_to_file(values),
            **({} if program is None else {PROGRAM_FILE: program}),
        }
        self._disk.install({**{file_name(name): data for name, data in files.items()}, _INSTALLED: mark})
        return self.program != before

    def container(self, files: Sequence[SourceFile]) -> Container:
        """Return a program of these files, in the dialect of the project."""
        return Container(tuple(files), self._settings.dialect, self._settings.resource)

    def sources(self) -> Container | None:
        """Return the sources that the rig file names, as they are at present; None if it names none.

        ValueError, with the name, for one that cannot be read.
        """
        paths = self._settings.program
        try:
            return self.container([source_of(path) for path in paths]) if paths else None
        except OSError as cause:
            raise ValueError(f"a source cannot be read: {cause.filename}: {cause.strerror}") from cause

    def load(self) -> Loaded:
        try:
            configuration = configuration_of_file(self._disk.read(self.configuration_file))
            return Loaded(configuration, parameters_of_file(self._disk.read(self.parameter_file)), True)
        except ValueError:
            return Loaded(Configuration(), {}, False)

    def store_configuration(self, configuration: Configuration) -> None:
        self._disk.write(self.configuration_file, configuration_to_file(configuration))

    def store_values(self, values: Mapping[str, Value]) -> None:
        self._disk.write(self.parameter_file, parameters_to_file(values))

    @property
    def program(self) -> bytes:
        """The content of the program file; empty if there is none, or if a download without a program emptied it."""
        return self._disk.read(PROGRAM_FILE) if PROGRAM_FILE in self._disk else b""

    def store_program(self, program: bytes) -> None:
        self._disk.write(PROGRAM_FILE, program)

    def files(self, values: Mapping[str, Value], program: bytes) -> list[tuple[str, bytes]]:
        """The files that a download of this program writes, in order."""
        return [
            (PROGRAM_FILE, program),
            (self.parameter_file, parameters_to_file(values)),
            *((name, self._bus_file(name)) for name in BUS_FILES),
            (self.configuration_file, configuration_to_file(self.load().configuration)),
        ]

    def _bus_file(self, name: str) -> bytes:
        """The file of a bus, empty without that bus; the content of \\CANMA.CON is our choice and is never read."""
        master = self._settings.can_master
        return master.model_dump_json(indent=1).encode() if name == CAN_MASTER_FILE and master is not None else b""
