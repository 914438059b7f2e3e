"""The types of a TwinCAT project, in a `.tsproj` or a `.tmc`, which its PLC programs use like those of their own files.

Source: the public form of builds 4022 to 4026: `DataTypes` with `DataType`, which has `SubItem`, `EnumInfo` or a type
that it names, and `Hides` the earlier versions of itself.  The text keeps the lines of the file for messages.
"""

import re
from typing import Final

from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.imports.xml import Element, attribute, element, elements, line_of, name_of, read_xml, text_of

SUFFIXES: Final = (".tsproj", ".tmc")
_ROOTS: Final = frozenset({"TcSmProject", "TcModuleClass"})
_NAME: Final = re.compile(r"[A-Za-z_]\w*")
_TYPE: Final = re.compile(r"[A-Za-z_][\w. ]*(?:\(\d{1,5}\))?")
"""The name of a type, `STRING(80)` or `POINTER TO INT`."""
_NUMBER: Final = re.compile(r"-?\d{1,18}")


def types_of(text: str, report: Report, known: set[str]) -> str:
    """Return the declarations of the types in a project; an empty text if it has none, or is damaged.

    A type whose name is known in small letters is left out, and the others become known.
    """
    root = read_xml(text, report)
    if root is None or name_of(root) not in _ROOTS:
        return ""
    kinds = [kind for group in elements(root, "DataTypes") for kind in elements(group, "DataType")]
    hidden = {attribute(one, "GUID") for kind in kinds for hides in elements(kind, "Hides") for one in elements(hides)}
    lines = _Lines()
    for kind in kinds:
        name = _named(element(kind, "Name"))
        if name and name.casefold() not in known and attribute(element(kind, "Name"), "GUID") not in hidden:
            known.add(name.casefold())
            _declare(name, kind, lines)
    return lines.text


class _Lines:
    """A text in which each part begins in the line that it has in the file, or later."""

    def __init__(self) -> None:
        self.text = ""

    def add(self, line: int, part: str) -> None:
        self.text += "\n" * max(0, line - 1 - self.text.count("\n")) + part + " "


def _declare(name: str, kind: Element, lines: _Lines) -> None:
    """Add the declaration of a type, unless it is of a form that Structured Text does not have."""
    base, components, values = element(kind, "BaseType"), elements(kind, "SubItem"), elements(kind, "EnumInfo")
    if components:
        parts = [(line_of(one), _component(one)) for one in components]
        if not all(part for _, part in parts):
            return
        lines.add(line_of(kind), f"TYPE {name} : STRUCT")
        for line, part in parts:
            lines.add(line, part)
        lines.add(0, "END_STRUCT; END_TYPE")
    elif values:
        prefix = attribute(element(kind, "Name"), "RemovableEnumPrefix")
        listed = [
            (_named(element(one, "Text")).removeprefix(prefix), text_of(element(one, "Enum")).strip()) for one in values
        ]
        if all(title and _NUMBER.fullmatch(number) for title, number in listed):
            items = ", ".join(f"{title} := {number}" for title, number in listed)
            of = _type(base)
            lines.add(line_of(kind), f"TYPE {name} : ({items}){f' {of}' if of else ''}; END_TYPE")
    elif spec := _spec(kind, base):
        lines.add(line_of(kind), f"TYPE {name} : {spec}; END_TYPE")


def _component(item: Element) -> str:
    name, spec = _named(element(item, "Name")), _spec(item, element(item, "Type"))
    return f"{name} : {spec};" if name and spec else ""


def _spec(of: Element, kind: Element | None) -> str:
    """Return a type, with the bounds of an array in front of it; an empty text if it has no form in the language."""
    bounds = []
    for info in elements(of, "ArrayInfo"):
        first, count = (text_of(element(info, name)).strip() for name in ("LBound", "Elements"))
        if not _NUMBER.fullmatch(first) or not _NUMBER.fullmatch(count):
            return ""
        bounds.append(f"{int(first)}..{int(first) + int(count) - 1}")
    named = _type(kind)
    return f"ARRAY[{', '.join(bounds)}] OF {named}" if bounds and named else named


def _type(node: Element | None) -> str:
    text = text_of(node).strip()
    return text if _TYPE.fullmatch(text) else ""


def _named(node: Element | None) -> str:
    text = text_of(node).strip()
    return text if _NAME.fullmatch(text) else ""
