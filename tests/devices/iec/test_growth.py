"""Work and stack of a compilation grow no worse than n log n with the text, for every construct of the language.

Work is counted in executed lines of Python, because seconds depend on the host.
"""

from collections.abc import Callable
from contextlib import suppress

import pytest
from exchange_documents import coil, contact, pou, rail, sink, source, tc6
from executed_lines import executed_lines
from iec_growth import DEEP, TODAY, WIDE

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.check import inheritance
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile

Text = Callable[[int], str]
STEPS = 8
"""Times by which a text becomes longer."""
MOST_GROWTH = STEPS * 2
"""n log n is 8 * 1.6 from 20 to 160 of a construct, and n squared is 64."""

A_FEW = 1_000
"""Lines that are executed more or less by chance, for example by a cache."""


def compiled(text: str, dialect: Dialect) -> None:
    """Compile a text, or have it refused."""
    with suppress(CompileError):
        compile_project([SourceFile("a.st", text)], StandaloneHost(VirtualClock()), dialect)


def work(text: str, dialect: Dialect) -> int:
    """Return how many lines of Python a compilation executes."""
    return executed_lines(lambda: compiled(text, dialect))


def growth(text: Text, dialect: Dialect, first: int = 20) -> float:
    """Return how much more work the same addition to a text is where the text is STEPS times as long."""
    compiled(text(first), dialect)  # what is read once for all, such as libraries
    begin, after, far, farther = (work(text(count), dialect) for count in _counts(first))
    return (farther - far) / max(after - begin, A_FEW)


def _counts(first: int) -> tuple[int, int, int, int]:
    return first, 2 * first, STEPS * first, STEPS * 2 * first


@pytest.mark.long
@pytest.mark.parametrize("construct", WIDE)
def test_work_grows_with_the_text(construct: str) -> None:
    assert growth(WIDE[construct], EPAS_4) < MOST_GROWTH


@pytest.mark.long
@pytest.mark.parametrize("construct", TODAY)
def test_work_grows_with_the_text_of_todays_languages(construct: str) -> None:
    assert growth(TODAY[construct], CODESYS) < MOST_GROWTH


def ladder(elements: str) -> str:
    return tc6(pou(f"<LD>{rail()}{elements}</LD>", variables={"a": "BOOL", "b": "BOOL"}))


def functions(elements: str) -> str:
    return tc6(pou(f"<FBD>{elements}</FBD>", variables={"x": "INT", "y": "INT"}))


def pairs_in_a_row(count: int) -> str:
    """Pairs of contacts in parallel, one pair behind the other: each doubles the ways through the rung."""
    ways, found = ["0"], ""
    for number in range(count):
        first, second = f"1{number:05}", f"2{number:05}"
        found += contact(first, "a", *ways) + contact(second, "b", *ways)
        ways = [first, second]
    return ladder(found + coil("9", "b", *ways))


DRAWN: dict[str, Text] = {
    "contacts in parallel": lambda n: ladder(
        "".join(contact(str(k), "a", "0") for k in range(1, n + 1)) + coil("9999", "b", *map(str, range(1, n + 1)))
    ),
    "coils": lambda n: ladder(contact("1", "a", "0") + "".join(coil(str(k + 2), "b", "1") for k in range(n))),
    "consumers": lambda n: functions(source("1", "x") + "".join(sink(str(k + 2), "y", "1") for k in range(n))),
    "networks": lambda n: functions(
        "".join(source(str(2 * k), "x") + sink(str(2 * k + 1), "y", str(2 * k)) for k in range(n))
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("construct", DRAWN)
def test_work_grows_with_a_drawing(construct: str) -> None:
    assert growth(DRAWN[construct], EDITION_3) < MOST_GROWTH


@pytest.mark.long
def test_work_grows_with_the_elements_and_not_with_the_ways_through_a_rung() -> None:
    compiled(pairs_in_a_row(1), EDITION_3)
    a_pair = (work(pairs_in_a_row(10), EDITION_3) - work(pairs_in_a_row(2), EDITION_3)) / 8
    assert work(pairs_in_a_row(40), EDITION_3) < 3 * 40 * a_pair


@pytest.mark.long
@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3, CODESYS], ids=lambda dialect: dialect.name)
@pytest.mark.parametrize("construct", DEEP)
def test_work_grows_with_the_levels_in_one_another(construct: str, dialect: Dialect) -> None:
    text = DEEP[construct]
    a_line = work(text(12), dialect) / len(text(12))
    for count in (24, 39, 200):
        assert work(text(count), dialect) < 3 * a_line * len(text(count)), count


@pytest.mark.long
@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3, CODESYS], ids=lambda dialect: dialect.name)
@pytest.mark.parametrize("construct", DEEP)
def test_no_depth_is_too_much_for_the_stack(construct: str, dialect: Dialect) -> None:
    compiled(DEEP[construct](2_500), dialect)


def test_what_function_blocks_inherit_has_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each has a copy, so the work grows with the methods of one times the others that extend it."""
    monkeypatch.setattr(inheritance, "MOST_INHERITED", 20)
    base = "FUNCTION_BLOCK B METHOD m : INT m := 1; END_METHOD METHOD n : INT n := 1; END_METHOD END_FUNCTION_BLOCK\n"
    blocks = "".join(f"FUNCTION_BLOCK D{number} EXTENDS B END_FUNCTION_BLOCK\n" for number in range(8))
    text = f"{base}{blocks}PROGRAM PLC_PRG VAR d : D7; x : INT; END_VAR x := d.m(); END_PROGRAM"
    with pytest.raises(CompileError) as refused:
        compile_project([SourceFile("a.st", text)], StandaloneHost(VirtualClock()), CODESYS)
    (mistake,) = (found for found in refused.value.mistakes if not found.is_note)
    assert (mistake.line, mistake.what) == (8, "the function blocks up to D6 inherit too much")
