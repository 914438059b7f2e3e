"""Types of PLCopen TC6: each is an element, `<BOOL/>`, `<derived name="TON"/>`, `<array>...`."""

from typing import Final

from lxml import etree

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.exchange.declared import (
    DEPTH,
    TypeReader,
    array,
    enumeration,
    initial,
    limits,
    plain_name,
    subrange,
    variable,
)
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.xml import attribute, comment_of, element, elements, line_of, name_of, text_of

Element = etree._Element

ELEMENTARY: Final = frozenset((
    "BOOL", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT", "REAL",
    "LREAL", "TIME", "DATE", "DT", "TOD", "TIME_OF_DAY", "DATE_AND_TIME", "LTIME", "LDATE", "LDT", "LTOD",
    "LTIME_OF_DAY", "LDATE_AND_TIME", "CHAR", "WCHAR",
))  # fmt: skip
_NOTHING: Final = tree.NamedType("")
"""Stands for a type that has a message already, so that nothing more is said about it."""


def read_type(node: Element | None, fragments: Fragments, depth: int = 0) -> tree.TypeSpec:
    """The type inside of an element such as `type`, `baseType` or `returnType`."""
    inner = next((child for child in elements(node) if name_of(child).casefold() != "adddata"), None)
    if node is None or inner is None:
        fragments.report.mistake(
            1 if node is None else line_of(node), "The type is missing", "an element such as <INT/>"
        )
        return _NOTHING
    if depth > DEPTH:
        fragments.report.mistake(line_of(inner), f"Types are nested more than {DEPTH} deep")
        return _NOTHING
    position = tree.Position(line_of(inner), 1)
    name = name_of(inner)
    if name.upper() in ELEMENTARY:
        return tree.NamedType(name.upper(), position=position)
    match name.casefold():
        case "string" | "wstring":
            length = attribute(inner, "length").strip()
            longest = fragments.expression(length, position.line) if length else None
            return tree.StringSpec(longest, name.casefold() == "wstring", position=position)
        case "derived":
            return _derived(inner, fragments)
        case "array":
            base = read_type(element(inner, "baseType"), fragments, depth + 1)
            return array(elements(inner, "dimension"), base, position, fragments)
        case "struct":
            fields = (variable(field, _nested(depth), fragments) for field in elements(inner, "variable"))
            return tree.StructSpec(tuple(field for field in fields if field is not None), position=position)
        case "enum":
            return _enumeration(inner, fragments)
        case "subrangesigned" | "subrangeunsigned":
            return _subrange(inner, fragments, depth)
        case "pointer":
            return tree.PointerSpec(read_type(element(inner, "baseType"), fragments, depth + 1), position=position)
    fragments.report.mistake(
        position.line, f"The type {name[:40]} is not known on this controller", "an elementary or a derived type"
    )
    return _NOTHING


def _enumeration(node: Element, fragments: Fragments) -> tree.TypeSpec:
    """An enumeration, perhaps of another integer type than INT."""
    spec = enumeration(node, elements(element(node, "values"), "value"), fragments)
    base = element(node, "baseType")
    kind = read_type(base, fragments) if base is not None else None
    if isinstance(kind, tree.NamedType) and kind.name != "INT":
        spec.base = kind.name
        if not fragments.dialect.has_typed_enumerations:
            hint = "Choose the dialect edition-3 or codesys."
            fragments.report.mistake(line_of(node), f"The enumeration is of the type {kind.name}", "INT", hint)
    return spec


def _nested(depth: int) -> TypeReader:
    return lambda node, fragments: read_type(node, fragments, depth + 1)


def _derived(node: Element, fragments: Fragments) -> tree.TypeSpec:
    """A name; some tools also write whole types there."""
    name = attribute(node, "name").strip()
    if not name:
        fragments.report.mistake(line_of(node), "The derived type has no name")
        return _NOTHING
    if "." in name and "[" not in name:
        name = plain_name(name)
    return fragments.type(name, line_of(node))


def _union(node: Element, fragments: Fragments) -> tree.StructSpec:
    components = (variable(field, read_type, fragments) for field in elements(node, "variable"))
    fields = tuple(field for field in components if field is not None)
    if not fragments.dialect.has_unions:
        fragments.report.mistake(
            line_of(node), "A UNION is not supported", "a structure", "Choose the dialect codesys."
        )
    return tree.StructSpec(fields, is_union=True, position=tree.Position(line_of(node), 1))


def _extend(node: Element, spec: tree.TypeSpec, fragments: Fragments) -> None:
    """Note the structure that a structure extends, which the tools of the CODESYS family add."""
    above = next(node.iter("{*}Extends"), None)
    if above is None:
        return
    if isinstance(spec, tree.StructSpec) and fragments.dialect.has_methods:
        spec.extends = plain_name(text_of(above))
    else:
        fragments.report.mistake(line_of(above), "EXTENDS is not supported here", hint="Choose the dialect codesys.")


def _subrange(node: Element, fragments: Fragments, depth: int) -> tree.TypeSpec:
    bounds = element(node, "range")
    range_ = None if bounds is None else limits(bounds, fragments)
    base = read_type(element(node, "baseType"), fragments, depth + 1)
    return subrange(node, base, range_, fragments)


def read_declaration(node: Element, fragments: Fragments) -> tree.TypeDeclaration | None:
    """A `dataType` element, or a `union` that the tools of the CODESYS family add."""
    name, line = attribute(node, "name").strip(), line_of(node)
    if not fragments.is_name(name, line, "a type"):
        return None
    with fragments.report.inside(f"type {name[:60]}"):
        spec = _union(node, fragments) if name_of(node) == "union" else read_type(element(node, "baseType"), fragments)
        _extend(node, spec, fragments)
        return tree.TypeDeclaration(
            name,
            spec,
            initial(element(node, "initialValue"), spec, fragments),
            comments=comment_of(element(node, "documentation")),
            position=tree.Position(line, 1),
        )
