"""Variables, their types and start values, as both exchange formats have them.

The formats differ in the case of their names, in how a type is written, and in where an address stands.
"""

import re
from collections.abc import Callable, Sequence
from typing import Final

from lxml import etree

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.exchange.tc6_added import with_arguments
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.xml import (
    attribute,
    comment_of,
    element,
    elements,
    formatted_text,
    is_set,
    line_of,
    name_of,
)

Element = etree._Element
TypeReader = Callable[[Element | None, Fragments], tree.TypeSpec]

_VARIABLES: Final = re.compile(r"\bVAR(?:_[A-Z]+)?\b", re.IGNORECASE)
DEPTH: Final = 60
"""Arrays, structures and values inside of one another."""

SECTIONS: Final = {
    "localvars": tree.Section.LOCAL, "vars": tree.Section.LOCAL, "tempvars": tree.Section.TEMP,
    "inputvars": tree.Section.INPUT, "outputvars": tree.Section.OUTPUT, "inoutvars": tree.Section.IN_OUT,
    "externalvars": tree.Section.EXTERNAL, "globalvars": tree.Section.GLOBAL,
}  # fmt: skip


def section(list_: Element, read_type: TypeReader, fragments: Fragments) -> tree.Variables | None:
    """A list of variables; None for lists that the language does not have, with a note."""
    kind = SECTIONS.get(name_of(list_).casefold())
    if kind is None:
        if elements(list_):
            fragments.report.note(line_of(list_), f"{name_of(list_)} is left out: the controller has no access paths")
        return None
    variables = [variable(child, read_type, fragments) for child in elements(list_, "variable")]
    return tree.Variables(
        kind,
        tuple(child for child in variables if child is not None),
        is_retain=is_set(list_, "retain"),
        is_persistent=is_set(list_, "persistent"),
        is_constant=is_set(list_, "constant"),
        name=attribute(list_, "name") if kind is tree.Section.GLOBAL else "",
        comments=comment_of(element(list_, "documentation")),
        position=tree.Position(line_of(list_), 1),
    )


def variable(node: Element, read_type: TypeReader, fragments: Fragments) -> tree.Variable | None:
    name, line = attribute(node, "name").strip(), line_of(node)
    if not fragments.is_name(name, line, "a variable"):
        return None
    with fragments.report.inside(f"variable {name[:60]}"):
        if attribute(node, "edgeDetection", "none").casefold() not in ("", "none"):
            fragments.report.mistake(
                line, "The input detects edges", "an input without edge", "Call R_TRIG or F_TRIG in the body instead."
            )
        spec = with_arguments(node, read_type(element(node, "type"), fragments), fragments)
        at = attribute(node, "address") or attribute(element(node, "address"), "address")
        return tree.Variable(
            name,
            spec,
            initial(element(node, "initialValue"), spec, fragments),
            fragments.address(at if at.startswith("%") else f"%{at}", line) if at.strip() else None,
            remark=" ".join(comment_of(element(node, "documentation"))).replace("\n", " "),
            position=tree.Position(line, 1),
        )


def initial(node: Element | None, spec: tree.TypeSpec, fragments: Fragments, depth: int = 0) -> tree.Initial | None:
    """A start value: simple, of an array, or of a structure."""
    value = next(iter(elements(node)), None)
    if value is None:
        return None
    line = line_of(value)
    if depth > DEPTH:
        fragments.report.mistake(line, f"Values are nested more than {DEPTH} deep")
        return None
    match name_of(value).casefold():
        case "simplevalue":
            return _simple(attribute(value, "value"), line, spec, fragments)
        case "arrayvalue":
            of_element = spec.element if isinstance(spec, tree.ArraySpec) else tree.NamedType("INT")
            values = [_repeated(part, of_element, fragments, depth + 1) for part in elements(value, "value")]
            parts = tuple(part for part in values if part is not None)
            return tree.ArrayInitial(parts, position=tree.Position(line, 1))
        case "structvalue":
            fields: list[tree.FieldInitial] = []
            for part in elements(value, "value"):
                inner = initial(part, tree.NamedType(""), fragments, depth + 1)
                if inner is not None:
                    position = tree.Position(line_of(part), 1)
                    fields.append(tree.FieldInitial(attribute(part, "member"), inner, position=position))
            return tree.StructInitial(tuple(fields), position=tree.Position(line, 1))
    fragments.report.mistake(
        line, f"The value {name_of(value)[:30]} is not known", "simpleValue, arrayValue, structValue"
    )
    return None


def _simple(text: str, line: int, spec: tree.TypeSpec, fragments: Fragments) -> tree.Initial | None:
    if not text.strip():
        return None
    if isinstance(spec, tree.StringSpec) and text[0] not in "'\"":
        # Some editors store the characters without quotes.
        position = tree.Position(line, 1)
        kind = tree.LiteralKind.WSTRING if spec.is_wide else tree.LiteralKind.STRING
        return tree.Literal(kind, text, position=position)
    return fragments.initial(text, line)


def _repeated(
    part: Element, spec: tree.TypeSpec, fragments: Fragments, depth: int
) -> tree.Initial | tree.Repeated | None:
    value = initial(part, spec, fragments, depth)
    count = attribute(part, "repetitionValue", "1").strip()
    if value is None or count in ("", "1"):
        return value
    times = fragments.expression(count, line_of(part))
    return None if times is None else tree.Repeated(times, value, position=tree.Position(line_of(part), 1))


def plain_text(node: Element | None, fragments: Fragments) -> tuple[tree.Variables, ...]:
    """The declarations of an element that has them as text, as the tools of the CODESYS family add them."""
    if node is None:
        return ()
    holder = next(
        (e for e in node.iter() if name_of(e).casefold() in ("interfaceasplaintext", "textdeclaration")), None
    )
    if holder is None:
        return ()
    text, line = formatted_text(holder)
    start = _VARIABLES.search(text)
    if start is None:
        return ()
    return fragments.variables(text[start.start() :], line + text.count("\n", 0, start.start()))


def array(
    dimensions: Sequence[Element], base: tree.TypeSpec, position: tree.Position, fragments: Fragments
) -> tree.TypeSpec:
    """An array; each dimension is an element with its limits, which are `*` in an ARRAY[*]."""
    if dimensions and all(attribute(e, end).strip() == "*" for e in dimensions for end in ("lower", "upper")):
        if not fragments.dialect.has_open_arrays:
            hint = "ARRAY[*] is known in the dialect edition-3."
            fragments.report.mistake(position.line, "An array has the limit *", "limits such as 1..10", hint)
        return tree.OpenArraySpec(len(dimensions), base, position=position)
    ranges = (limits(limit, fragments) for limit in dimensions)
    return tree.ArraySpec(tuple(limit for limit in ranges if limit is not None), base, position=position)


def limits(node: Element, fragments: Fragments) -> tree.Range | None:
    """The range in the attributes `lower` and `upper`; None with a message."""
    line = line_of(node)
    low = fragments.expression(attribute(node, "lower"), line)
    high = fragments.expression(attribute(node, "upper"), line)
    return None if low is None or high is None else tree.Range(low, high, position=tree.Position(line, 1))


def subrange(node: Element, base: tree.TypeSpec, range_: tree.Range | None, fragments: Fragments) -> tree.TypeSpec:
    """Return the part of an integer type; the type itself after a message."""
    if range_ is None or not isinstance(base, tree.NamedType):
        fragments.report.mistake(line_of(node), "The subrange is incomplete", "a range and an integer type")
        return base
    return tree.SubrangeSpec(base, range_.low, range_.high, position=tree.Position(line_of(node), 1))


def enumeration(node: Element, values: Sequence[Element], fragments: Fragments) -> tree.EnumSpec:
    named: list[tree.EnumValue] = []
    for value in values:
        line, name = line_of(value), attribute(value, "name").strip()
        if fragments.is_name(name, line, "a value of an enumeration"):
            number = attribute(value, "value").strip()
            given = fragments.expression(number, line) if number else None
            named.append(tree.EnumValue(name, given, position=tree.Position(line, 1)))
    return tree.EnumSpec(tuple(named), position=tree.Position(line_of(node), 1))


def plain_name(name: str) -> str:
    """Return a name without the library or name space in front of it."""
    return name.strip().rpartition(".")[2]


def known_interfaces(
    word: str, names: Sequence[str], line: int, fragments: Fragments, known: frozenset[str]
) -> tuple[str, ...]:
    """Return the interfaces of the document without the names of libraries; others are left out with a note."""
    interfaces: list[str] = []
    for name in filter(str.strip, names):
        if plain_name(name).casefold() in known and fragments.dialect.has_methods:
            interfaces.append(plain_name(name))
        else:
            fragments.report.note(line, f"{word} {name.strip()[:60]} is left out")
    return tuple(interfaces)
