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


def read_type(of: Element | None, fragments: Fragments, depth: int = 0) -> tree.TypeSpec:
    """The type inside of an element such as `type`, `baseType` or `returnType`."""
    inner = next((child for child in elements(of) if name_of(child).casefold() != "adddata"), None)
    if of is None or inner is None:
        fragments.report.mistake(1 if of is None else line_of(of), "The type is missing", "an element such as <INT/>")
        return _NOTHING
    if depth > DEPTH:
        fragments.report.mistake(line_of(inner), f"Types are nested more than {DEPTH} deep")
        return _NOTHING
    place = tree.Place(line_of(inner), 1)
    name = name_of(inner)
    if name.upper() in ELEMENTARY:
        return tree.NamedType(name.upper(), place=place)
    match name.casefold():
        case "string" | "wstring":
            length = attribute(inner, "length").strip()
            longest = fragments.expression(length, place.line) if length else None
            return tree.StringSpec(longest, name.casefold() == "wstring", place=place)
        case "derived":
            return _derived(inner, fragments)
        case "array":
            base = read_type(element(inner, "baseType"), fragments, depth + 1)
            return array(elements(inner, "dimension"), base, place, fragments)
        case "struct":
            fields = (variable(field, _nested(depth), fragments) for field in elements(inner, "variable"))
            return tree.StructSpec(tuple(field for field in fields if field is not None), place=place)
        case "enum":
            return _enumeration(inner, fragments)
        case "subrangesigned" | "subrangeunsigned":
            return _subrange(inner, fragments, depth)
        case "pointer":
            return tree.PointerSpec(read_type(element(inner, "baseType"), fragments, depth + 1), place=place)
    fragments.report.mistake(
        place.line, f"The type {name[:40]} is not known on this controller", "an elementary or a derived type"
    )
    return _NOTHING


def _enumeration(of: Element, fragments: Fragments) -> tree.TypeSpec:
    """An enumeration, perhaps of another integer type than INT."""
    found = enumeration(of, elements(element(of, "values"), "value"), fragments)
    base = element(of, "baseType")
    kind = read_type(base, fragments) if base is not None else None
    if isinstance(kind, tree.NamedType) and kind.name != "INT":
        found.base = kind.name
        if not fragments.dialect.has_typed_enumerations:
            hint = "Choose the dialect edition-3 or codesys."
            fragments.report.mistake(line_of(of), f"The enumeration is of the type {kind.name}", "INT", hint)
    return found


def _nested(depth: int) -> TypeReader:
    return lambda of, fragments: read_type(of, fragments, depth + 1)


def _derived(of: Element, fragments: Fragments) -> tree.TypeSpec:
    """A name; some tools also write whole types there."""
    name = attribute(of, "name").strip()
    if not name:
        fragments.report.mistake(line_of(of), "The derived type has no name")
        return _NOTHING
    if "." in name and "[" not in name:
        name = plain_name(name)
    return fragments.type(name, line_of(of))


def _union(of: Element, fragments: Fragments) -> tree.StructSpec:
    found = (variable(field, read_type, fragments) for field in elements(of, "variable"))
    fields = tuple(field for field in found if field is not None)
    if not fragments.dialect.has_unions:
        fragments.report.mistake(line_of(of), "A UNION is not supported", "a structure", "Choose the dialect codesys.")
    return tree.StructSpec(fields, is_union=True, place=tree.Place(line_of(of), 1))


def _extend(of: Element, spec: tree.TypeSpec, fragments: Fragments) -> None:
    """Note the structure that a structure extends, which the tools of the CODESYS family add."""
    above = next(of.iter("{*}Extends"), None)
    if above is None:
        return
    if isinstance(spec, tree.StructSpec) and fragments.dialect.has_methods:
        spec.extends = plain_name(text_of(above))
    else:
        fragments.report.mistake(line_of(above), "EXTENDS is not supported here", hint="Choose the dialect codesys.")


def _subrange(of: Element, fragments: Fragments, depth: int) -> tree.TypeSpec:
    bounds = element(of, "range")
    found = None if bounds is None else limits(bounds, fragments)
    base = read_type(element(of, "baseType"), fragments, depth + 1)
    return subrange(of, base, found, fragments)


def read_declaration(of: Element, fragments: Fragments) -> tree.TypeDeclaration | None:
    """A `dataType` element, or a `union` that the tools of the CODESYS family add."""
    name, line = attribute(of, "name").strip(), line_of(of)
    if not fragments.is_name(name, line, "a type"):
        return None
    with fragments.report.inside(f"type {name[:60]}"):
        spec = _union(of, fragments) if name_of(of) == "union" else read_type(element(of, "baseType"), fragments)
        _extend(of, spec, fragments)
        return tree.TypeDeclaration(
            name,
            spec,
            initial(element(of, "initialValue"), spec, fragments),
            comments=comment_of(element(of, "documentation")),
            place=tree.Place(line, 1),
        )
