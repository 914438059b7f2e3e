"""No document makes an import raise: random changes of documents that hold every kind of element."""

import contextlib
import re
from collections.abc import Callable

from every_element import DOCUMENTS
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import PlainHost

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.imports import read_source
from fieldrig_devices.iec.printer import print_unit
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile

_PARTS = re.compile(r"<[^>]*>|[^<]+")
_VALUES = re.compile(r'"[^"]*"')
_ODD = ("", "0", "1", "-1", "a", "1e999", "9" * 30, "???", "T#1s", "%QX", "\u00e4", "(", "P", "none", "x.y[1]", "''")


def _without(parts: list[str], at: int, draw: Callable[[int], int]) -> list[str]:
    return parts[:at] + parts[at + 1 :]


def _twice(parts: list[str], at: int, draw: Callable[[int], int]) -> list[str]:
    return [*parts[:at], parts[at], *parts[at:]]


def _moved(parts: list[str], at: int, draw: Callable[[int], int]) -> list[str]:
    to = draw(len(parts) - 1)
    rest = _without(parts, at, draw)
    return [*rest[:to], parts[at], *rest[to:]]


def _other_value(parts: list[str], at: int, draw: Callable[[int], int]) -> list[str]:
    values = _VALUES.findall("".join(parts))
    new = values[draw(len(values) - 1)] if draw(1) and values else f'"{_ODD[draw(len(_ODD) - 1)]}"'
    return [*parts[:at], _VALUES.sub(lambda _: new, parts[at], count=1), *parts[at + 1 :]]


def _whole_element_away(parts: list[str], at: int, draw: Callable[[int], int]) -> list[str]:
    """Stays well-formed, so that the readers see it."""
    name = re.match(r"<([\w:]+)", parts[at])
    if name is None or parts[at].endswith("/>"):
        return _without(parts, at, draw)
    depth = 0
    for end in range(at, len(parts)):
        opened = re.match(r"<(/?)" + re.escape(name.group(1)) + r"[\s>/]", parts[end])
        if opened is not None and not parts[end].endswith("/>"):
            depth += -1 if opened.group(1) else 1
        if depth == 0:
            return parts[:at] + parts[end + 1 :]
    return parts


_CHANGES = (_other_value, _other_value, _whole_element_away, _whole_element_away, _without, _twice, _moved)


@st.composite
def changed(draw_: st.DrawFn, most: int) -> str:
    """A document with some changes."""
    parts = _PARTS.findall(DOCUMENTS[draw_(st.integers(0, len(DOCUMENTS) - 1))])

    def draw(last: int) -> int:
        return draw_(st.integers(0, max(0, last)))

    for _ in range(draw(most)):
        change = draw_(st.sampled_from(_CHANGES))
        parts = change(parts, draw(len(parts) - 1), draw) or [""]
    return "".join(parts)


@settings(deadline=None)
@given(changed(3))
def test_a_changed_document_compiles_or_is_refused(document: str) -> None:
    """The trees that an import makes are sound enough for every stage behind it."""
    with contextlib.suppress(CompileError):
        compile_project([SourceFile("x.xml", document)], PlainHost())


@settings(deadline=None)
@given(changed(6), st.sampled_from((EPAS_4, EDITION_3)))
def test_a_changed_document_is_read_with_messages(document: str, dialect: Dialect) -> None:
    unit, mistakes = read_source("x.xml", document, dialect)
    assert isinstance(unit, tree.Unit)
    assert all(mistake.file == "x.xml" and mistake.line >= 1 for mistake in mistakes)
    print_unit(unit)  # every tree that an import makes can be written


@settings(deadline=None)
@given(st.text(alphabet=st.characters(codec="utf-8")) | st.text(alphabet="<>/=\"' &;pouTcPlcObject\n"))
def test_any_text_is_read_with_messages(text: str) -> None:
    read_source("x", text, EPAS_4)
    read_source("x", f"<{text}", EPAS_4)


def test_the_documents_are_sound_before_they_are_changed() -> None:
    for document in DOCUMENTS:
        _, mistakes = read_source("x.xml", document, EDITION_3)
        assert not [mistake for mistake in mistakes if "XML is damaged" in mistake.what]
