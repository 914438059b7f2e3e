"""XML from outside, read so that it can do no harm: no DOCTYPE, no entities, no network, limits of size.

The limit of depth is that of lxml, 256 elements inside of one another.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Final, cast

from lxml import etree

from fieldrig_devices.iec.imports.report import Report

CHARACTERS: Final = 32 * 1024 * 1024
"""The largest document."""

_PROLOG: Final = re.compile(r"\s*(?:<\?.*?\?>\s*|<!--.*?-->\s*)*", re.DOTALL)
_DECLARATION: Final = re.compile(r"^\s*<\?xml[^>]*\?>")

Element = etree._Element


def read_xml(text: str, report: Report) -> Element | None:
    """Return the root element, or None with a message."""
    if len(text) > CHARACTERS:
        report.mistake(1, f"The document has {len(text)} characters", f"at most {CHARACTERS}")
        return None
    text = text.lstrip("\ufeff")
    if text.startswith("<!DOCTYPE", _PROLOG.match(text).end()):  # type: ignore[union-attr]  # the pattern matches anything
        report.mistake(1, "The document has a document type declaration", "a document without DOCTYPE and entities")
        return None
    # The text is decoded already, so its declaration must not name another encoding.
    text = _DECLARATION.sub(lambda match: "\n" * match.group().count("\n"), text, count=1)
    parser = etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        root = etree.fromstring(text.encode("utf-8", "replace"), parser)
    except etree.XMLSyntaxError as fault:
        report.mistake(max(1, fault.lineno or 1), f"The XML is damaged: {fault.msg}")
        return None
    return root


def name_of(element: Element) -> str:
    """The name without its namespace."""
    tag = element.tag
    return tag.rpartition("}")[2] if isinstance(tag, str) else ""


def namespace_of(element: Element) -> str:
    tag = element.tag
    return tag[1:].partition("}")[0] if isinstance(tag, str) and tag.startswith("{") else ""


def line_of(element: Element) -> int:
    return cast("int | None", element.sourceline) or 1


def elements(parent: Element | None, *names: str) -> list[Element]:
    """The children with one of these names, in any namespace; all of them without a name.  Case does not matter."""
    if parent is None:
        return []
    wanted = {name.casefold() for name in names}
    children = [child for child in parent if isinstance(child.tag, str)]
    return [child for child in children if name_of(child).casefold() in wanted] if wanted else children


def element(parent: Element | None, *path: str) -> Element | None:
    """The first child at the end of this path of names."""
    for name in path:
        parent = next(iter(elements(parent, name)), None)
    return parent


def attribute(node: Element | None, name: str, default: str = "") -> str:
    """An attribute by its name without namespace."""
    if node is None:
        return default
    plain = node.get(name)
    if plain is not None:
        return plain
    return next((str(value) for key, value in node.attrib.items() if str(key).endswith(f"}}{name}")), default)


def word(node: Element | None, name: str) -> str:
    """An attribute whose value is one of a few words, in small letters."""
    return attribute(node, name).strip().casefold()


def is_set(node: Element | None, name: str) -> bool:
    return word(node, name) in ("true", "1")


TRUTHS: Final = ("true", "false", "1", "0")


def refuse_unknown(node: Element, values: Mapping[str, Sequence[str]], what: object, report: Report) -> None:
    """Report attributes with a value that their schema does not know, which would be overlooked."""
    for name, known in values.items():
        given = word(node, name)
        if given and given not in known:
            report.mistake(line_of(node), f"The {what} has {name}={given[:40]!r}", ", ".join(known))


def number(node: Element | None, name: str) -> float | None:
    """A finite number from an attribute; None without one."""
    try:
        value = float(attribute(node, name))
    except ValueError:
        return None
    return value if -1e12 < value < 1e12 else None


def text_of(node: Element | None) -> str:
    """All text in the element, in document order, unchanged: its first line is the line of the element."""
    text = "" if node is None else "".join(map(str, node.itertext(with_tail=False)))
    return text.replace("\r\n", "\n").replace("\r", "\n")


def formatted_text(node: Element | None) -> tuple[str, int]:
    """The text of an element with XHTML inside or without, and the line where it begins.

    A break or the end of a paragraph ends a line, if the document does not do so itself.
    """
    if node is None:
        return "", 1
    parts: list[str] = [node.text or ""]
    for event, child in etree.iterwalk(node, events=("start", "end")):
        if child is node:
            continue
        if event == "start":
            parts.append(child.text or "")
            continue
        is_line = name_of(child).casefold() in ("br", "p", "div")
        if is_line and not _ends_line(parts[-1]) and not _begins_line(child.tail):
            parts.append("\n")
        parts.append(child.tail or "")
    first = next(iter(elements(node)), None)
    if first is not None and not (node.text or "").strip():
        # The text begins in the paragraph; the line of an element is that of the end of its tag.
        return "".join(parts[1:]).replace("\r\n", "\n").replace("\r", "\n"), line_of(first)
    return "".join(parts).replace("\r\n", "\n").replace("\r", "\n"), line_of(node)


def _ends_line(text: str) -> bool:
    return "\n" in text[len(text.rstrip()) :]


def _begins_line(text: str | None) -> bool:
    return text is not None and "\n" in text[: len(text) - len(text.lstrip())]


def comment_of(node: Element | None) -> tuple[str, ...]:
    """Documentation as a comment of the program; () if it is empty."""
    text = text_of(node).strip().replace("(*", "( *").replace("*)", "* )")
    return (f"(* {text} *)",) if text else ()
