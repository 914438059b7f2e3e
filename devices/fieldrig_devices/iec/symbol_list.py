"""The list of a program's symbols in XML, as CODESYS V3 writes it for HMIs and gateways: NAME.DEVICE.Application.xml.

Source: the element and attribute names of `Symbolconfiguration.xsd` by files that CODESYS V3.5 has written.  A type is
`T_` and its IEC name in which everything but letters and digits is an underscore.  Programs are nodes without a type;
what they declare has one, and its parts are in the list of types.  Left out: attributes of pragmas, and the offsets of
the client-side layout (`nativesize` is the size in our memory, which has no gaps).
"""

import re
from collections.abc import Iterator
from typing import Final
from xml.etree import ElementTree as ET

from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.symbols import Symbol, Symbols
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import (
    ArrayType,
    BlockType,
    EnumType,
    ObjectType,
    PointerType,
    StringType,
    StructType,
    SubrangeType,
    Type,
)

NAMESPACE: Final = "http://www.3s-software.com/schemas/Symbolconfiguration.xsd"
VERSION: Final = "3.5.12.0"
"""Version of the form, which is not a version of ours."""
_CLASSES: Final = {
    "BOOL": "Bool", "BYTE": "Byte", "WORD": "Word", "DWORD": "DWord", "LWORD": "LWord", "SINT": "SInt", "INT": "Int",
    "DINT": "DInt", "LINT": "LInt", "USINT": "USInt", "UINT": "UInt", "UDINT": "UDInt", "ULINT": "ULInt",
    "REAL": "Real", "LREAL": "LReal", "TIME": "Time", "SIGNED_TIME": "Time",
    "DATE": "Date", "TOD": "TimeOfDay", "DT": "DateAndTime",
    "LTIME": "LTime", "UNSIGNED_LTIME": "LTime",
    "LDATE": "LDate", "LTOD": "LTimeOfDay", "LDT": "LDateAndTime", "CHAR": "Char", "WCHAR": "WChar",
}  # fmt: skip
"""`typeclass` of the elementary types."""
_LONG_NAMES: Final = {"TOD": "TIME_OF_DAY", "DT": "DATE_AND_TIME"}
_HIDDEN: Final = frozenset({Section.TEMP, Section.EXTERNAL, Section.IN_OUT})
"""Variables that have no place of their own, so no client can read them."""


def symbol_list(symbols: Symbols, project: str, device: str, application: str = "Application") -> bytes:
    """Return the list as a file."""
    ET.register_namespace("", NAMESPACE)
    root = ET.Element(_tag("Symbolconfiguration"))
    _header(root, project, device, application)
    types = _Types(ET.SubElement(root, _tag("TypeList")))
    nodes = ET.SubElement(root, _tag("NodeList"))
    top = ET.SubElement(nodes, _tag("Node"), name=application)
    for symbol in sorted(symbols.children(), key=lambda symbol: symbol.name.casefold()):
        _node(top, symbols, symbol, types)
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n'.encode()


def _tag(name: str) -> str:
    return f"{{{NAMESPACE}}}{name}"


def _header(root: ET.Element, project: str, device: str, application: str) -> None:
    header = ET.SubElement(root, _tag("Header"))
    ET.SubElement(header, _tag("Version")).text = VERSION
    ET.SubElement(
        header,
        _tag("SymbolConfigObject"),
        version=VERSION,
        runtimeid=VERSION,
        libversion=VERSION,
        compiler=VERSION,
        lmm=VERSION,
        profile="fieldrig",
        settings="SupportOPCUA, XmlIncludeComments",
    )
    ET.SubElement(header, _tag("ProjectInfo"), name=project, devicename=device, appname=application)


def _node(parent: ET.Element, symbols: Symbols, symbol: Symbol, types: "_Types") -> None:
    if isinstance(symbol.type, BlockType) and _is_program(symbol):
        own = ET.SubElement(parent, _tag("Node"), name=symbol.name)
        _comment(own, symbol.comment)
        for part in sorted(symbols.children(symbol.path), key=lambda part: part.name.casefold()):
            _node(own, symbols, part, types)
        return
    access = "ReadWrite" if symbol.is_writable else "Read"
    own = ET.SubElement(parent, _tag("Node"), name=symbol.name, type=types.name(symbol.type), access=access)
    _comment(own, symbol.comment)


def _is_program(symbol: Symbol) -> bool:
    """True for programs, whose instance has the name of the type (PD-356)."""
    return isinstance(symbol.type, BlockType) and symbol.type.name.casefold() == symbol.path.casefold()


def _comment(owner: ET.Element, text: str) -> None:
    if text:
        ET.SubElement(owner, _tag("Comment")).text = text


class _Types:
    """The list of types; each type is added before the one that uses it."""

    def __init__(self, parent: ET.Element) -> None:
        self._parent = parent
        self._known: set[str] = set()

    def name(self, kind: Type) -> str:
        """Return the name of a type in the list, and add it if it is missing."""
        iec = _iec_name(kind)
        name = f"T_{re.sub(r'[^A-Za-z0-9_]', '_', _mangled(kind, iec))}"
        if name not in self._known:
            self._known.add(name)
            self._add(kind, name, iec)
        return name

    def _add(self, kind: Type, name: str, iec: str) -> None:
        match kind:
            case Elementary():
                self._simple(name, kind.size, _CLASSES[kind.value], iec, is_swapped=kind.family is not Family.BOOL)
            case StringType():
                self._simple(name, kind.size, "WString" if kind.is_wide else "String", iec, is_swapped=False)
            case PointerType():
                self._simple(name, kind.size, "Pointer", iec, is_swapped=True, basetype=self.name(kind.to))
            case ObjectType():
                self._simple(name, kind.size, "DWord", "DWORD", is_swapped=True)
            case SubrangeType():
                limits = {"lowerborder": str(kind.low), "upperborder": str(kind.high)}
                self._simple(name, kind.size, "Subrange", iec, is_swapped=True, basetype=self.name(kind.base), **limits)
            case ArrayType():
                self._array(kind, name, iec)
            case EnumType():
                self._enumeration(kind, name, iec)
            case StructType() | BlockType():
                self._compound(kind, name, iec)

    def _simple(self, name: str, size: int, typeclass: str, iec: str, *, is_swapped: bool, **more: str) -> None:
        facts = {"name": name, "size": str(size), "swapsize": str(size if is_swapped else 0)}
        ET.SubElement(self._parent, _tag("TypeSimple"), {**facts, "typeclass": typeclass, "iecname": iec, **more})

    def _array(self, kind: ArrayType, name: str, iec: str) -> None:
        ranges, element = _dimensions(kind)
        size, base = str(kind.size), self.name(element)
        facts = {"name": name, "size": size, "nativesize": size, "typeclass": "Array", "iecname": iec, "basetype": base}
        own = ET.SubElement(self._parent, _tag("TypeArray"), facts)
        for low, high in ranges:
            ET.SubElement(own, _tag("ArrayDim"), minrange=str(low), maxrange=str(high))

    def _enumeration(self, kind: EnumType, name: str, iec: str) -> None:
        base = self.name(kind.base)
        own = self._user_defined(name, kind.size, "Enum", "ENUM", iec, basetype=base)
        for value, number in kind.values.items():
            ET.SubElement(own, _tag("UserDefElement"), iecname=value, type=base, enumvalue=str(number))

    def _compound(self, kind: StructType | BlockType, name: str, iec: str) -> None:
        parts = [(part, self.name(part[1])) for part in _parts(kind)]
        pou_class = "STRUCTURE" if isinstance(kind, StructType) else "FUNCTION_BLOCK"
        own = self._user_defined(name, kind.size, "Userdef", pou_class, iec)
        for (part, _, offset, section, comment), type_name in parts:
            element = ET.SubElement(
                own, _tag("UserDefElement"), iecname=part, type=type_name, byteoffset=str(offset), vartype=section
            )
            _comment(element, comment)

    def _user_defined(self, name: str, size: int, typeclass: str, pou_class: str, iec: str, **more: str) -> ET.Element:
        facts = {"name": name, "size": str(size), "nativesize": str(size), "typeclass": typeclass}
        facts |= {"pouclass": pou_class, "iecname": iec}
        return ET.SubElement(self._parent, _tag("TypeUserDef"), {**facts, **more})


def _parts(kind: StructType | BlockType) -> Iterator[tuple[str, Type, int, str, str]]:
    """Yield the parts: name, type, offset, kind of variable, and comment."""
    if isinstance(kind, StructType):
        for field in kind.fields.values():
            yield field.name, field.type, field.offset, "VAR", field.comment
        return
    for variable in kind.pou.variables.values() if kind.pou is not None else ():
        is_declared = variable.name[:1] != "$"
        if is_declared and variable.section not in _HIDDEN and variable.location is None:
            yield variable.name, variable.type, max(variable.offset, 0), variable.section.value, variable.comment


def _dimensions(kind: ArrayType) -> tuple[list[tuple[int, int]], Type]:
    """Return the ranges of all dimensions, and the type of an element."""
    ranges, element = [(kind.low, kind.high)], kind.element
    while isinstance(element, ArrayType):
        ranges.append((element.low, element.high))
        element = element.element
    return ranges, element


def _iec_name(kind: Type) -> str:
    match kind:
        case Elementary():
            return _LONG_NAMES.get(kind.value, str(kind.value))
        case ArrayType():
            ranges, element = _dimensions(kind)
            return f"ARRAY [{', '.join(f'{low}..{high}' for low, high in ranges)}] OF {_iec_name(element)}"
        case SubrangeType():
            return f"{_iec_name(kind.base)} ({kind.low}..{kind.high})"
        case PointerType():
            return f"POINTER TO {_iec_name(kind.to)}"
        case _:
            return str(kind)


def _mangled(kind: Type, iec: str) -> str:
    """Return the name for the list: `ARRAY__0__10__0__20__OF_INT`."""
    if isinstance(kind, ArrayType):
        ranges, element = _dimensions(kind)
        limits = "__".join(f"{low}__{high}" for low, high in ranges)
        return f"ARRAY__{limits}__OF_{_mangled(element, _iec_name(element))}"
    return iec.replace("(", "_").replace(")", "").replace(" ", "_")
