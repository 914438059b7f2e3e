"""A project with suites: its files, those of the libraries that are beside it as sources, and what runs.

A `.plcproj`, a folder with sources, or single files are a project.  Libraries are looked for in the folders around it,
by the names in their own `.plcproj`.
"""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from fieldrig.errors import UsageError
from fieldrig.text.source_text import decoded
from fieldrig_devices.iec import conditional
from fieldrig_devices.iec.dialect import CODESYS
from fieldrig_devices.iec.imports import event_classes, io_links, tsproj
from fieldrig_devices.iec.imports.event_classes import EventClass
from fieldrig_devices.iec.imports.plcproj import SOURCES, SUFFIX, PlcProject, read_plcproj
from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.library.sources import types_of
from fieldrig_devices.iec.tcunit.namespaces import CODE, Space, separate
from fieldrig_devices.languages.source_file import SourceFile

LEVELS_UP: Final = 6
"""How far above a project its libraries are looked for."""
MOST_FOLDERS: Final = 4_000
"""Folders that are looked into on each level, so that a large disk takes no time."""
BUILT_IN: Final = frozenset({"tcunit"})
"""Libraries that are never taken from sources beside the project."""


@dataclass(slots=True)
class Sources:
    """The texts of a project and of its libraries."""

    path: Path
    name: str
    files: list[SourceFile] = field(default_factory=list)
    library_files: list[SourceFile] = field(default_factory=list)
    parameters: dict[tuple[str, str], str] = field(default_factory=dict)
    """Constants of libraries by the list of global variables and the name, both in small letters."""
    links: list[io_links.Link] = field(default_factory=list)
    """The outputs that the TwinCAT project links with inputs of the program."""
    absent: list[str] = field(default_factory=list)
    """Files and libraries that are not there."""


def projects_in(path: Path) -> list[Path]:
    """Return the projects at a path: the path itself, or the `.plcproj` files in a folder if it has any."""
    if not path.is_dir():
        return [path]
    return sorted(path.rglob(f"*{SUFFIX}")) or [path]


def opened(path: Path) -> Sources:
    """Read a project with its libraries.  UsageError if it cannot be read."""
    if path.suffix.casefold() != SUFFIX:
        inside = sorted(path.rglob("*")) if path.is_dir() else [path]
        files = [file for file in inside if file.suffix.casefold() in SOURCES or file == path]
        return Sources(path, path.stem, [_read(file) for file in files if file.is_file()])
    report = Report(str(path))
    project = read_plcproj(path, _read(path).text, report)
    if project is None:
        raise UsageError(f"{path} cannot be read", str(report.mistakes[0]) if report.mistakes else "")
    made = Sources(path, project.name)
    made.absent += [f"the file {name}" for name in project.missing]
    made.library_files += _types_around(project)
    made.links = [link for file in _around(project) for link in io_links.links_of(file.text, Report(file.name))]
    classes = [*_events_around(project), *(one for library in _add_libraries(project, made) for one in library)]
    if text := event_classes.declarations(classes):
        made.library_files.append(SourceFile(str(path), text))  # TwinCAT makes them too, so no file has them
    return made


def _types_around(project: PlcProject) -> list[SourceFile]:
    """Return the types of the TwinCAT project that a PLC project belongs to, which is in the folder above it.

    Those of our libraries, which belong to TwinCAT itself, are left out: other parts of the libraries need them.
    """
    made, known = list[SourceFile](), set(types_of(CODESYS))
    for file in _around(project):
        text = tsproj.types_of(file.text, Report(file.name), known)
        made += [SourceFile(file.name, text)] if text else []
    return made


def _around(project: PlcProject) -> Iterator[SourceFile]:
    """Yield the files of the TwinCAT project that a PLC project belongs to."""
    folder = project.path.parent.parent
    for suffix in tsproj.SUFFIXES:
        yield from map(_read, sorted(folder.glob(f"*{suffix}")))


def _events_around(project: PlcProject) -> list[EventClass]:
    """Return the classes of events of the same TwinCAT project."""
    return [one for file in _around(project) for one in event_classes.classes_of(file.text, Report(file.name))]


def _add_libraries(project: PlcProject, made: Sources) -> list[list[EventClass]]:
    """Add the sources of a project, and of its libraries and theirs; return the events of the libraries."""
    spaces, events = {project.path: _space(project)}, list[list[EventClass]]()
    waiting, finder = [project], _Finder(project.path)
    while waiting:
        user = waiting.pop(0)
        for name, reference in user.references.items():
            found = None if name in BUILT_IN or name in project.names else finder.project(name)
            if found is None:
                for key, value in reference.parameters.items():
                    made.parameters.setdefault(key, value)
                continue
            if found.path not in spaces:
                spaces[found.path] = _space(found)
                waiting.append(found)
                made.library_files += _types_around(found)
                events.append(_events_around(found))
            space = spaces[found.path]
            spaces[user.path].named.append((reference.namespace, space))
            for key, value in reference.parameters.items():
                space.parameters.setdefault(key, value)
    separate([*spaces.values()])
    own, *libraries = spaces.values()
    made.files += own.files
    for library in libraries:
        made.library_files += library.files
        made.parameters = {**library.parameters, **made.parameters}
    return events


def _space(project: PlcProject) -> Space:
    return Space(project.name, [_compiled(_read(file), project) for file in project.files])


def _compiled(file: SourceFile, project: PlcProject) -> SourceFile:
    """Return a file that begins with the names that the project defines, if it has conditions of the compiler."""
    if not project.defines or conditional.IS_USED.search(file.text) is None:
        return file
    defined = "".join(f"{{define {name}}}" for name in project.defines)
    return replace(file, text=CODE.sub(lambda code: defined + code[0], file.text, count=1))


class _Finder:
    """Finds the projects of libraries, level by level above a project."""

    def __init__(self, path: Path) -> None:
        self._levels = iter([path.parent, *path.resolve().parents][: LEVELS_UP + 1])
        self._own = path
        self._known: dict[str, PlcProject] = {}
        self._seen: set[Path] = set()

    def project(self, name: str) -> PlcProject | None:
        while name not in self._known:
            level = next(self._levels, None)
            if level is None or level == level.parent:
                return None
            for path in _projects_below(level):
                self._note(path)
        return self._known[name]

    def _note(self, path: Path) -> None:
        if path in self._seen or path.resolve() == self._own.resolve():
            return
        self._seen.add(path)
        try:
            project = read_plcproj(path, _read(path).text, Report(str(path)))
        except UsageError:
            return
        if project is not None:
            for name in project.names:
                self._known.setdefault(name, project)


def _projects_below(folder: Path) -> Iterator[Path]:
    for number, (inside, folders, files) in enumerate(os.walk(folder)):
        if number >= MOST_FOLDERS:
            return
        folders[:] = sorted(name for name in folders if not name.startswith((".", "_")))
        yield from (Path(inside, name) for name in sorted(files) if name.casefold().endswith(SUFFIX))


def _read(path: Path) -> SourceFile:
    try:
        return SourceFile(str(path), decoded(path.read_bytes()))
    except (OSError, ValueError) as cause:
        raise UsageError(f"{path} cannot be read", str(cause)) from cause


def overriding(parameters: Mapping[tuple[str, str], str], name: str) -> Sequence[tuple[str, str]]:
    """Return the constants that are set in the list with a name, in small letters."""
    return [(key, value) for (named, key), value in parameters.items() if named == name.casefold()]
