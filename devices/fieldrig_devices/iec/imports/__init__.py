"""Programs of other tools come over without retyping: text, PLCopen XML, IEC 61131-10, ENI and TwinCAT files.

What a file is, its content says; its name only tells Instruction List from Structured Text, which the parser does.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.imports import eni, export, twincat
from fieldrig_devices.iec.imports.exchange import part10, tc6
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.project_files import is_no_text, said_of
from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.imports.xml import Element, line_of, name_of, namespace_of, read_xml
from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.languages.source_file import SourceFile

_DRAWING: Final = re.compile(r'[<:"](?:FBD|LD|SFC)\b', re.IGNORECASE)
_KNOWN: Final = "PLCopen XML (TC6), IEC 61131-10, an object of the ENI, or a file of TwinCAT 3"


def read_sources(
    files: Sequence[SourceFile],
    dialect: Dialect,
    libraries: Sequence[tree.Unit] = (),
    on_file: Callable[[int], None] = lambda number: None,
) -> list[tuple[tree.Unit, list[Mistake]]]:
    """Read the files of a project: what is drawn in one of them may use what another one declares.

    So a document with drawings beside other files is read again when all declarations are known.  `on_file` is called
    with the number of each file.
    """
    given = [declaration for unit in libraries for declaration in unit.declarations]
    read = []
    for number, file in enumerate(files):
        on_file(number)
        read.append(read_source(file.name, file.text, dialect, given))
    drawn = [number for number, file in enumerate(files) if _has_drawing(file.text)] if len(files) > 1 else []
    units = [unit for unit, _ in read]
    for number in drawn:
        others = (unit for other, unit in enumerate(units) if other != number)
        around = [*given, *(declaration for unit in others for declaration in unit.declarations)]
        read[number] = read_source(files[number].name, files[number].text, dialect, around)
    return read


def read_source(
    name: str, text: str, dialect: Dialect, around: Sequence[tree.Declaration] = ()
) -> tuple[tree.Unit, list[Mistake]]:
    """Read a source file of any supported form.  Never raises: what is wrong is in the mistakes.

    `around` is declared elsewhere, and gives types to what is drawn.
    """
    report = Report(name)
    if (said := said_of(name)) is not None and is_no_text(text):
        report.mistake(1, f"This is {said[0]}", "files with the text of programs", said[1])
        return tree.Unit(name, ()), report.mistakes
    if not text.lstrip("\ufeff \t\r\n").startswith("<"):
        return export.read_text(name, text.lstrip("\ufeff"), dialect)
    root = read_xml(text, report)
    unit = tree.Unit(name, ()) if root is None else _read(root, report, dialect, around)
    return unit, sorted(report.mistakes)


def _has_drawing(text: str) -> bool:
    return text.lstrip("\ufeff \t\r\n").startswith("<") and _DRAWING.search(text) is not None


def is_foreign(text: str) -> bool:
    """True for a document that is well-formed and of no format of programs, such as one about terminals."""
    if not text.lstrip("\ufeff \t\r\n").startswith("<"):
        return False
    root = read_xml(text, Report(""))
    return root is not None and not _is_known(root)


def _is_known(root: Element) -> bool:
    is_eni = not namespace_of(root) and name_of(root) in eni.ROOTS
    return name_of(root) == "TcPlcObject" or part10.is_project(root) or tc6.is_project(root) or is_eni


def _read(root: Element, report: Report, dialect: Dialect, around: Sequence[tree.Declaration]) -> tree.Unit:
    if name_of(root) == "TcPlcObject":
        return twincat.read_object(root, report, _of_today(dialect))
    if part10.is_project(root):
        return tree.Unit(report.file, part10.read_project(root, Fragments(report, _of_today(dialect), around)))
    if tc6.is_project(root):
        return tree.Unit(report.file, tc6.read_project(root, Fragments(report, _of_today(dialect), around)))
    if not namespace_of(root) and name_of(root) in eni.ROOTS:
        return eni.read_object(root, report, dialect)
    said = said_of(report.file)
    if said is not None:
        report.mistake(line_of(root), f"This is {said[0]}", "files with the text of programs", said[1])
    else:
        report.mistake(line_of(root), f"<{name_of(root)[:60]}> is not the root of a known format", _KNOWN)
    return tree.Unit(report.file, ())


def _of_today(dialect: Dialect) -> Dialect:
    """The dialect with comments to the end of the line, which today's tools write in every file."""
    return replace(dialect, has_line_comments=True)
