"""Types of IEC 61131-10: names, types that are defined in place, and declared types."""

from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.exchange.declared import (
    DEPTH,
    array,
    enumeration,
    initial,
    limits,
    subrange,
    variable,
)
from fieldrig_devices.iec.imports.exchange.part10_bodies import type_of
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.xml import (
    Element,
    attribute,
    comment_of,
    element,
    elements,
    line_of,
    text_of,
)  # fmt: skip

NOTHING: Final = tree.NamedType("")
"""Stands for a type that has a message already."""


def read_type(node: Element | None, fragments: Fragments, depth: int = 0) -> tree.TypeSpec:
    """A reference to a type: its name, or a type that is defined in place."""
    line = 1 if node is None else line_of(node)
    name = element(node, "TypeName")
    if name is not None:
        return _named(text_of(name).strip(), line_of(name), fragments)
    inner = element(node, "InstantlyDefinedType")
    if inner is not None:
        return _specified(inner, fragments, depth + 1)
    if node is not None and text_of(node).strip() and not elements(node):
        return _named(text_of(node).strip(), line, fragments)
    fragments.report.mistake(line, "The type is missing", "a TypeName or an InstantlyDefinedType")
    return NOTHING


def _named(name: str, line: int, fragments: Fragments) -> tree.TypeSpec:
    """A type by its name, whose name space does not count."""
    if "[" not in name and "(" not in name:
        name = name.replace("\\", ".").rpartition(".")[2]
    return fragments.type(name, line)


def _specified(node: Element, fragments: Fragments, depth: int = 0) -> tree.TypeSpec:
    position, kind = tree.Position(line_of(node), 1), type_of(node)
    if depth > DEPTH:
        fragments.report.mistake(position.line, f"Types are nested more than {DEPTH} deep")
        return NOTHING
    match kind:
        case "arraytypespec":
            base = read_type(element(node, "BaseType"), fragments, depth)
            dimensions = [_limits_of(e) for e in elements(node, "DimensionSpec")]
            return array(dimensions, base, position, fragments)
        case "structtypespec":
            fields = (variable(member, read_type, fragments) for member in elements(node, "Member"))
            return tree.StructSpec(tuple(field for field in fields if field is not None), position=position)
        case "enumtypespec" | "enumtypewithnamedvaluespec":
            return enumeration(node, elements(node, "Enumerator"), fragments)
        case "subrangetypespec":
            return _subrange(node, fragments, depth)
        case "directlyderivedtypespec" | "derivedtypespec":
            return read_type(element(node, "BaseType"), fragments, depth)
    fragments.report.mistake(
        position.line, f"The type specification {kind[:40] or 'without xsi:type'} is not known", "an array, structure, "
        "enumeration, subrange or derived type"
    )  # fmt: skip
    return NOTHING


def _limits_of(dimension: Element) -> Element:
    range_ = element(dimension, "IndexRange")
    return dimension if range_ is None else range_


def _subrange(node: Element, fragments: Fragments, depth: int) -> tree.TypeSpec:
    base = read_type(element(node, "BaseType"), fragments, depth)
    range_ = next((limits(e, fragments) for e in (*elements(node), node) if attribute(e, "lower")), None)
    return subrange(node, base, range_, fragments)


def read_declaration(node: Element, fragments: Fragments) -> tree.TypeDeclaration | None:
    name, line = attribute(node, "name").strip(), line_of(node)
    if not fragments.is_name(name, line, "a type"):
        return None
    with fragments.report.inside(f"type {name[:60]}"):
        specification = element(node, "UserDefinedTypeSpec")
        if specification is None:
            fragments.report.mistake(line, "The type has no specification", "a UserDefinedTypeSpec")
            return None
        spec = _specified(specification, fragments)
        start = initial(element(specification, "InitialValue"), spec, fragments)
        comments = comment_of(element(node, "Documentation"))
        return tree.TypeDeclaration(name, spec, start, comments=comments, position=tree.Position(line, 1))
