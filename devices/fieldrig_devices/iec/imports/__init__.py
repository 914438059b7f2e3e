"""Programs of other tools come over without retyping: text, PLCopen XML, IEC 61131-10, ENI and TwinCAT files.

What a file is, its content says; its name only tells Instruction List from Structured Text, which the parser does.
"""

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

_KNOWN: Final = "PLCopen XML (TC6), IEC 61131-10, an object of the ENI, or a file of TwinCAT 3"


def read_source(name: str, text: str, dialect: Dialect) -> tuple[tree.Unit, list[Mistake]]:
    """Read a source file of any supported form.  Never raises: what is wrong is in the mistakes."""
    report = Report(name)
    if (said := said_of(name)) is not None and is_no_text(text):
        report.mistake(1, f"This is {said[0]}", "files with the text of programs", said[1])
        return tree.Unit(name, ()), report.mistakes
    if not text.lstrip("\ufeff \t\r\n").startswith("<"):
        return export.read_text(name, text.lstrip("\ufeff"), dialect)
    root = read_xml(text, report)
    unit = tree.Unit(name, ()) if root is None else _read(root, report, dialect)
    return unit, sorted(report.mistakes)


def is_foreign(text: str) -> bool:
    """True for a document that is well-formed and of no format of programs, such as one about terminals."""
    if not text.lstrip("\ufeff \t\r\n").startswith("<"):
        return False
    root = read_xml(text, Report(""))
    return root is not None and not _is_known(root)


def _is_known(root: Element) -> bool:
    is_eni = not namespace_of(root) and name_of(root) in eni.ROOTS
    return name_of(root) == "TcPlcObject" or part10.is_project(root) or tc6.is_project(root) or is_eni


def _read(root: Element, report: Report, dialect: Dialect) -> tree.Unit:
    if name_of(root) == "TcPlcObject":
        return twincat.read_object(root, report, _of_today(dialect))
    if part10.is_project(root):
        return tree.Unit(report.file, part10.read_project(root, Fragments(report, _of_today(dialect))))
    if tc6.is_project(root):
        return tree.Unit(report.file, tc6.read_project(root, Fragments(report, _of_today(dialect))))
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
