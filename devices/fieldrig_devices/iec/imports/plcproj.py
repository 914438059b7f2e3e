"""The list of files of a TwinCAT PLC project, `.plcproj`: its sources, its libraries, and their parameters.

Source: files of builds 4020 to 4026 by their public form, which is that of MSBuild.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PureWindowsPath
from typing import Final

from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.imports.xml import Element, attribute, element, elements, name_of, read_xml, text_of
from fieldrig_devices.languages.source_file import found_beside

SUFFIX: Final = ".plcproj"
SOURCES: Final = frozenset({".tcpou", ".tcgvl", ".tcdut", ".tctleo", ".tcio", ".tctto", ".st"})
"""The endings of the files with declarations and tasks; others are pictures, recipes and descriptions."""


@dataclass(slots=True)
class Reference:
    """A library that a project uses."""

    name: str
    namespace: str
    parameters: dict[tuple[str, str], str] = field(default_factory=dict)
    """Constants by the list of global variables and the name, both in small letters."""


@dataclass(slots=True)
class PlcProject:
    """A `.plcproj` file that has been read."""

    path: Path
    name: str
    title: str
    files: Sequence[Path]
    missing: Sequence[str]
    """The names of files that are not there, as the project writes them."""
    references: Mapping[str, Reference]
    """The libraries by their names in small letters."""
    defines: Sequence[str] = ()
    """The names that are defined for conditions of the compiler."""

    @property
    def names(self) -> frozenset[str]:
        """The names by which another project may refer to this one, in small letters."""
        return frozenset(name.casefold() for name in (self.name, self.title, self.path.stem) if name)


def read_plcproj(path: Path, text: str, report: Report) -> PlcProject | None:
    """Read a project; None with a message in the report if the text is none."""
    root = read_xml(text, report)
    if root is None:
        return None
    if name_of(root) != "Project":
        report.mistake(1, f"<{name_of(root)[:60]}> is not the root of a PLC project", "<Project>")
        return None
    heads = {name_of(e): text_of(e).strip() for group in elements(root, "PropertyGroup") for e in elements(group)}
    files, missing = list[Path](), list[str]()
    references: dict[str, Reference] = {}
    for group in elements(root, "ItemGroup"):
        for item in elements(group):
            if name_of(item) == "Compile":
                _add_file(item, path.parent, files, missing)
            elif name_of(item) in ("PlaceholderReference", "LibraryReference"):
                reference = _reference(item)
                references[reference.name.casefold()] = reference
            elif name_of(item) == "PlaceholderResolution":
                _add_parameters(item, references.get(attribute(item, "Include").casefold()))
    name = heads.get("Name", "") or path.stem
    defines = re.findall(r"[A-Za-z_]\w*", heads.get("CompilerDefines", ""))
    return PlcProject(path, name, heads.get("Title", ""), files, missing, references, defines)


def _add_file(item: Element, folder: Path, files: list[Path], missing: list[str]) -> None:
    name = attribute(item, "Include")
    link = text_of(element(item, "Link")).strip()
    is_excluded = text_of(element(item, "ExcludeFromBuild")).strip().casefold() == "true"
    if is_excluded or PureWindowsPath(name).suffix.casefold() not in SOURCES:
        return
    found = found_beside(folder, name) or _above(folder, name)
    if found is not None:
        files.append(found)
    else:
        missing.append(name or link)


def _above(folder: Path, name: str) -> Path | None:
    r"""Return a file from a folder beside that of the project, `..\Shared\F.TcPOU`; None if there is none."""
    parts = list(PureWindowsPath(name).parts)
    while parts and parts[0] == "..":
        folder, parts = folder.parent, parts[1:]
    return found_beside(folder, "/".join(parts)) if parts else None


def _reference(item: Element) -> Reference:
    name = attribute(item, "Include").split(",")[0].strip()
    made = Reference(name, text_of(element(item, "Namespace")).strip() or name)
    _add_parameters(item, made)
    return made


def _add_parameters(item: Element, reference: Reference | None) -> None:
    if reference is None:
        return
    for group in elements(item, "Parameters"):
        for parameter in elements(group, "Parameter"):
            key = text_of(element(parameter, "Key")).strip().casefold()
            value = text_of(element(parameter, "Value")).strip()
            if key and value:
                reference.parameters[attribute(parameter, "ListName").casefold(), key] = value
