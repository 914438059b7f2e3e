"""Methods, properties, interfaces and inheritance, which the tools of the CODESYS family add to PLCopen TC6.

Source: exports of CODESYS V3.5 and TwinCAT 3 by their public form.  TC6 itself ends at edition 2 of the language, so
these are `addData`: a `Method` or `Property` below its POU, an `Inheritance` below the interface of a POU, and an
`Interface` beside the POUs.  Access specifiers are attributes of `AccessModifiers`, and words of the header where a
declaration is text.  A library's name in front of a type, `LIB.IDrive`, does not count.
"""

import re
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.assembly import Raw, prototype
from fieldrig_devices.iec.imports.exchange.declared import (
    SECTIONS,
    Element,
    known_interfaces,
    plain_name,
    plain_text,
    section,
)
from fieldrig_devices.iec.imports.exchange.tc6_bodies import read_body
from fieldrig_devices.iec.imports.exchange.tc6_types import read_type
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
    text_of,
)  # fmt: skip

_WORDS: Final = ("PUBLIC", "PRIVATE", "PROTECTED", "INTERNAL", "ABSTRACT", "FINAL", "OVERRIDE")
_HEAD: Final = re.compile(r"\b(?:FUNCTION_BLOCK|METHOD|PROPERTY)\b((?:\s+[A-Za-z_]\w*)+)", re.IGNORECASE)

_EXTENDED: Final = re.compile(r"\bINTERFACE\s+\w+\s+EXTENDS\s+([\w.]+(?:\s*,\s*[\w.]+)*)", re.IGNORECASE)


def blocks(pou: Element, interface: Element | None, fragments: Fragments) -> tuple[tree.Variables, ...]:
    """Return the variables of a POU or a method."""
    lists = [e for e in elements(interface) if name_of(e).casefold() in (*SECTIONS, "accessvars")]
    read = [block for e in lists if (block := section(e, read_type, fragments)) is not None]
    used = [block for block in read if block.variables]
    return tuple(used) or plain_text(element(pou, "addData"), fragments) or plain_text(interface, fragments)


def methods(node: Element, fragments: Fragments) -> list[Raw]:
    """Return the methods of a POU or an interface, and the accessors of its properties."""
    methods: list[Raw] = []
    for added in node.iter("{*}Method", "{*}Property"):
        name, kind = attribute(added, "name").strip(), name_of(added).lower()
        if not fragments.dialect.has_methods:
            fragments.report.mistake(
                line_of(added),
                f"The {kind} {name[:60]} is not supported",
                "functions, function blocks and actions",
                "Choose the dialect codesys.",
            )
        elif fragments.is_name(name, line_of(added), f"a {kind}"):
            with fragments.report.inside(f"{kind} {name[:60]}"):
                methods += [_method(added, fragments)] if kind == "method" else _property(added, fragments)
    return methods


def _method(node: Element, fragments: Fragments) -> Raw:
    interface = element(node, "interface")
    result = element(interface, "returnType")
    raw = Raw(tree.PouKind.FUNCTION, attribute(node, "name").strip(), line_of(node))
    raw.comments = comment_of(element(node, "documentation"))
    raw.result = read_type(result, fragments) if result is not None else None
    raw.blocks = blocks(node, interface, fragments) or plain_text(node, fragments)
    raw.bodies = [drawn for body in elements(node, "body") if (drawn := read_body(body, fragments.report)) is not None]
    raw.modifiers = modifiers(node, fragments)
    return raw


def _property(node: Element, fragments: Fragments) -> list[Raw]:
    kind = read_type(element(element(node, "interface"), "returnType"), fragments)
    own = modifiers(node, fragments)
    accessors: list[Raw] = []
    for part in elements(node):
        word = name_of(part).upper().removesuffix("ACCESSOR")
        if word in ("GET", "SET"):
            raw = _method(part, fragments)
            raw.name, raw.result, raw.accessor, raw.modifiers = attribute(node, "name").strip(), kind, word, own
            accessors.append(raw)
    return accessors


def modifiers(node: Element, fragments: Fragments) -> tuple[str, ...]:
    """Return the words in front of the name of a POU, method or property, from its attributes or its text."""
    if not fragments.dialect.has_methods:
        return ()
    words = {word for e in _own(node, "AccessModifiers") for word in _WORDS if is_set(e, word.capitalize())}
    for holder in _own(node, "InterfaceAsPlainText"):
        head = _HEAD.search(_without_comments(formatted_text(holder)[0]))
        for word in head[1].upper().split() if head is not None else ():
            if word not in _WORDS:
                break  # the name of the POU, method or property
            words.add(word)
    for added in _own(node, "AccessModifiers"):
        for name in map(str, added.attrib):
            if name.upper() not in _WORDS and is_set(added, name):
                fragments.report.note(line_of(added), f"The modifier {name[:30]} is left out")
    return tuple(word for word in _WORDS if word in words)


def _own(node: Element, name: str) -> list[Element]:
    """The added elements of this name that belong to the element itself, and not to a method or property in it."""
    inner = ("Method", "Property", "GetAccessor", "SetAccessor")
    return [
        e
        for e in node.iter(f"{{*}}{name}")
        if next(p for p in e.iterancestors() if name_of(p) in inner or p is node) is node
    ]


def _without_comments(text: str) -> str:
    return re.sub(r"\(\*.*?\*\)|//[^\n]*|\{[^}]*\}", " ", text, flags=re.DOTALL)


# ---- inheritance


def inherit(raw: Raw, interface: Element | None, fragments: Fragments, known: frozenset[str]) -> None:
    """Note what a function block extends and implements; `known` are the interfaces of the document in small letters.

    Interfaces of libraries are left out with a note.
    """
    if interface is None:
        return
    names = [name for added in interface.iter("{*}Implements") for name in text_of(added).split(",")]
    raw.implements = known_interfaces("IMPLEMENTS", names, raw.line, fragments, known)
    above = next(interface.iter("{*}Extends"), None)
    if above is not None and fragments.dialect.has_methods:
        raw.extends = plain_name(text_of(above))
    elif above is not None:
        fragments.report.mistake(line_of(above), "EXTENDS is not supported", hint="Choose the dialect codesys.")


# ---- interfaces


def interfaces(root: Element) -> list[Element]:
    """Return the interfaces of a document; the `interface` of a POU is another element."""
    return [e for e in root.iter("{*}Interface") if attribute(e, "name").strip()]


def _extended_in_text(node: Element) -> list[str]:
    """Return the names behind EXTENDS in the header of an interface."""
    texts = (_without_comments(formatted_text(holder)[0]) for holder in _own(node, "InterfaceAsPlainText"))
    heads = (head for text in texts if (head := _EXTENDED.search(text)) is not None)
    return [name for head in heads for name in head[1].split(",")]


def interface(node: Element, fragments: Fragments, known: frozenset[str]) -> tree.Interface | None:
    name, line = attribute(node, "name").strip(), line_of(node)
    if not fragments.dialect.has_methods:
        what = f"The interface {name[:60]} is not supported"
        fragments.report.mistake(line, what, "functions, function blocks and actions", "Choose the dialect codesys.")
        return None
    if not fragments.is_name(name, line, "an interface"):
        return None
    with fragments.report.inside(f"INTERFACE {name[:60]}"):
        prototypes = [prototype(raw) for raw in methods(node, fragments)]
        names = [part for e in _own(node, "Extends") for part in text_of(e).split(",")] or _extended_in_text(node)
        above = known_interfaces("EXTENDS", names, line, fragments, known)
        comments = comment_of(element(node, "documentation"))
    return tree.Interface(name, above, tuple(prototypes), comments=comments, position=tree.Position(line, 1))
