"""Files of TwinCAT 3: POUs, types and global variables as XML around declarations and Structured Text.

Source: files of builds 4020 to 4026 by their public form.  A `TcPlcObject` contains one POU, DUT, GVL, Itf or Task.
The declaration has no closing keyword; the body, actions, methods and properties are elements of their own.  Bodies in
LD, FBD, SFC and CFC are archives of the editor.
"""

import re
from dataclasses import replace
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.imports.pieces import Pieces
from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.imports.xml import Element, attribute, element, elements, line_of, name_of, text_of
from fieldrig_devices.iec.parser import parse

_HEAD: Final = re.compile(r"\b(PROGRAM|FUNCTION_BLOCK|FUNCTION)\b", re.IGNORECASE)
_ARCHIVES: Final = {"nwl": "LD or FBD", "sfc": "SFC", "cfc": "CFC", "uml": "UML", "il": "IL"}
_QUALIFIED: Final = re.compile(r"\{\s*attribute\s+'qualified_only'\s*\}", re.IGNORECASE)
_US_A_MS: Final = 1_000


def read_object(root: Element, report: Report, dialect: Dialect) -> tree.Unit:
    """The one object of a `TcPlcObject`."""
    inner = next((e for e in elements(root) if name_of(e) in _READERS), None)
    if inner is None:
        names = ", ".join(name_of(e) for e in elements(root)) or "nothing"
        report.mistake(line_of(root), f"The file contains {names[:80]}", "a POU, DUT, GVL or Task")
        return tree.Unit(report.file, ())
    with report.inside(f"{name_of(inner)} {attribute(inner, 'Name')[:60]}"):
        return _READERS[name_of(inner)](inner, report, dialect)


def _pou(node: Element, report: Report, dialect: Dialect) -> tree.Unit:
    pieces = Pieces()
    _declaration(node, pieces, report)
    head = _HEAD.search(_without_comments(pieces.text()))
    if head is None:
        report.mistake(line_of(node), "The declaration has no header", "PROGRAM, FUNCTION_BLOCK or FUNCTION and a name")
        return tree.Unit(report.file, ())
    _implementation(node, pieces, report)
    pieces.close(f"END_{head.group().upper()}")
    for part in elements(node, "Action"):
        with report.inside(f"action {attribute(part, 'Name')[:60]}"):
            pieces.add(f"ACTION {attribute(part, 'Name')}:", line_of(part))
            _implementation(part, pieces, report)
            pieces.close("END_ACTION")
    for part in elements(node, "Method"):
        with report.inside(f"method {attribute(part, 'Name')[:60]}"):
            if dialect.has_methods:
                _declaration(part, pieces, report)
                _implementation(part, pieces, report)
                pieces.close("END_METHOD")
            else:
                report.mistake(line_of(part), "A method is not supported", "actions", "Choose the dialect codesys.")
    for part in elements(node, "Property"):
        with report.inside(f"property {attribute(part, 'Name')[:60]}"):
            if dialect.has_methods:
                _property(part, pieces, report)
            else:
                report.mistake(line_of(part), "A property is not supported", "actions", "Choose the dialect codesys.")
    for part in elements(node, "Transition"):
        report.mistake(
            line_of(part), f"The transition {attribute(part, 'Name')[:60]} belongs to an SFC body", hint=_EXPORT
        )
    return _parsed(pieces, report, dialect)


def _property(node: Element, pieces: Pieces, report: Report) -> None:
    _declaration(node, pieces, report)
    for part in elements(node):
        if name_of(part) in ("Get", "Set"):
            word = name_of(part).upper()
            pieces.add(word, line_of(part))
            if element(part, "Declaration") is not None:
                _declaration(part, pieces, report)
            _implementation(part, pieces, report)
            pieces.close(f"END_{word}")
    pieces.close("END_PROPERTY")


def _declared(node: Element, report: Report, dialect: Dialect) -> tree.Unit:
    """A type or a list of global variables."""
    pieces = Pieces()
    _declaration(node, pieces, report)
    unit = _parsed(pieces, report, dialect)
    if name_of(node) == "GVL":
        lists = [declaration for declaration in unit.declarations if isinstance(declaration, tree.Variables)]
        is_qualified = any(map(_QUALIFIED.fullmatch, lists[0].comments)) if lists else False
        for block in lists:
            block.name, block.is_qualified = attribute(node, "Name"), is_qualified
    return unit


def _interface(node: Element, report: Report, dialect: Dialect) -> tree.Unit:
    if not dialect.has_methods:
        name = attribute(node, "Name")[:60]
        report.mistake(line_of(node), f"The interface {name} is not supported", hint="Choose the dialect codesys.")
        return tree.Unit(report.file, ())
    pieces = Pieces()
    _declaration(node, pieces, report)
    for part in elements(node):
        if name_of(part) == "Method":
            _declaration(part, pieces, report)
            pieces.close("END_METHOD")
        elif name_of(part) == "Property":
            _property(part, pieces, report)
    pieces.close("END_INTERFACE")
    return _parsed(pieces, report, dialect)


def _task(node: Element, report: Report, dialect: Dialect) -> tree.Unit:
    """A task with its programs; its cycle time is in microseconds."""
    position = tree.Position(line_of(node), 1)
    cycle, priority = (_number(node, name, report) for name in ("CycleTime", "Priority"))
    name = re.sub(r"\W", "_", attribute(node, "Name"), flags=re.ASCII) or "Task"
    interval = None
    if cycle is not None:
        if cycle % _US_A_MS:
            report.note(position.line, f"The cycle time of {cycle} us is rounded up to whole milliseconds")
        ms = -(-cycle // _US_A_MS)
        interval = tree.Literal(tree.LiteralKind.TIME, ms, f"T#{ms}ms", position=position)
    number = None
    if priority is not None:
        number = tree.Literal(tree.LiteralKind.INTEGER, priority, str(priority), position=position)
    called = [text_of(element(call, "Name")).strip() for call in elements(node, "PouCall")]
    programs = tuple(tree.ProgramInstance(called_name, name, called_name, position=position) for called_name in called)
    task = tree.TaskDeclaration(name, number, interval, position=position)
    return tree.Unit(report.file, (tree.Configuration(name, (), (task,), programs, position=position),))


def _number(node: Element, name: str, report: Report) -> int | None:
    child = element(node, name)
    text = text_of(child).strip()
    if text.isascii() and text.isdecimal() and len(text) < 10:
        return int(text)
    if child is not None:
        report.mistake(line_of(child), f"{name} is {text[:30]}", "a whole number")
    return None


_EXPORT: Final = (
    "Export the POU as PLCopen XML in TwinCAT (PLC project, context menu, Export PLCopenXML), and import that file."
)
_READERS: Final = {
    "POU": _pou,
    "DUT": _declared,
    "EnumerationTextList": _declared,
    "GVL": _declared,
    "Itf": _interface,
    "Task": _task,
}


def _declaration(node: Element, pieces: Pieces, report: Report) -> None:
    declaration = element(node, "Declaration")
    if declaration is None:
        report.mistake(line_of(node), "The <Declaration> is missing")
    else:
        pieces.add(text_of(declaration), line_of(declaration))


def _implementation(node: Element, pieces: Pieces, report: Report) -> None:
    body = next(iter(elements(element(node, "Implementation"))), None)
    if body is None:
        return
    if name_of(body) == "ST":
        pieces.add(text_of(body), line_of(body))
        return
    if _is_empty_drawing(body):
        return
    language = _ARCHIVES.get(name_of(body).casefold(), name_of(body)[:30])
    report.mistake(
        line_of(body), f"The body is in {language}, as an archive of TwinCAT's editor", "a body in ST", _EXPORT
    )


def _is_empty_drawing(body: Element) -> bool:
    """True for a CFC, or networks of LD or FBD, with nothing in it: TwinCAT writes so for a new unit."""
    lists = {"cfc": ("InnerList",), "nwl": ("NetworkItems", "ILLines")}.get(name_of(body).casefold(), ())
    found = [node for node in body.iter() if isinstance(node.tag, str) and attribute(node, "n") in lists]
    return bool(found) and not any(elements(node) for node in found)


def _without_comments(text: str) -> str:
    return re.sub(r"\(\*.*?\*\)|//[^\n]*|\{[^}]*\}", " ", text, flags=re.DOTALL)


def _parsed(pieces: Pieces, report: Report, dialect: Dialect) -> tree.Unit:
    unit, mistakes = parse(pieces.text(), report.file, replace(dialect, reserves_configurations=False))
    report.take(mistakes)
    return unit
