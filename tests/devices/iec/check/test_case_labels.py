"""Labels that a CASE has twice: IEC 61131-3, 7.3.3.3.3 runs the first branch, CODESYS V3 refuses it (C0216, C0217)."""

from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.mistakes import CompileError, Mistake
from fieldrig_devices.languages.source_file import SourceFile

HEAD = """
TYPE Colour : (red, green, blue); END_TYPE
VAR_GLOBAL CONSTANT two : INT := 2; END_VAR
PROGRAM Main
VAR n : INT; c : Colour; b : BYTE; found : INT; END_VAR
"""
TWICE = [
    ("n", "1: found := 1; 1: found := 2;", "1"),
    ("n", "1, 1: found := 1;", "1"),
    ("n", "3..5: found := 1; 4: found := 2;", "4"),
    ("n", "4: found := 1; 3..5: found := 2;", "3..5"),
    ("n", "1..3: found := 1; 3..5: found := 2;", "3..5"),
    ("n", "two: found := 1; 2: found := 2;", "2"),
    ("n", "16#0A: found := 1; 10: found := 2;", "10"),
    ("n", "-3: found := 1; -5..-1: found := 2;", "-5..-1"),
    ("b", "2#11: found := 1; 3: found := 2;", "3"),
    ("c", "red: found := 1; green, red: found := 2;", "0"),
]
ONCE = ["1: found := 1; 2: found := 2;", "1..3: found := 1; 4..5: found := 2;", "-1: found := 1; 1: found := 2;"]


def mistakes(selector: str, branches: str, dialect: str) -> list[Mistake]:
    """Return the mistakes and notes about labels."""
    text = f"{HEAD}CASE {selector} OF {branches} END_CASE;\nEND_PROGRAM\n"
    try:
        files = [SourceFile("main.st", text)]
        found: Sequence[Mistake] = compile_project(files, StandaloneHost(VirtualClock()), DIALECTS[dialect]).notes
    except CompileError as wrong:
        found = wrong.mistakes
    return [mistake for mistake in found if "label" in mistake.what]


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize(("selector", "branches", "label"), TWICE)
def test_a_label_that_occurs_twice_is_named(dialect: str, selector: str, branches: str, label: str) -> None:
    (mistake,) = mistakes(selector, branches, dialect)
    assert mistake.what == f"the label {label} occurs twice in this CASE"
    assert mistake.is_note is (dialect != "codesys")


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("branches", ONCE)
def test_labels_that_differ_are_none(dialect: str, branches: str) -> None:
    assert mistakes("n", branches, dialect) == []


@settings(deadline=None, max_examples=25)
@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(0, 4)), min_size=1, max_size=6))
def test_ranges_are_told_just_if_they_have_a_value_in_common(parts: list[tuple[int, int]]) -> None:
    values = [value for low, more in parts for value in range(low, low + more + 1)]
    branches = " ".join(f"{low}..{low + more}: found := 1;" for low, more in parts)
    assert bool(mistakes("n", branches, "codesys")) is (len(set(values)) < len(values))
