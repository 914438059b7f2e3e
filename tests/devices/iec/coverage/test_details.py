"""Conditions, MC/DC and the states of enumerations, worked out by hand."""

from collections.abc import Mapping

import pytest
from iec_program import IecBench

from fieldrig.coverage.collecting import collecting
from fieldrig.coverage.places import DETAILS, Kind
from fieldrig.coverage.reports.lcov import lcov
from fieldrig.coverage.reports.table import said
from fieldrig.coverage.summary import Coverage
from fieldrig_devices.iec.dialect import CODESYS

VARIABLES = "a, b, i : INT; x, y, z : BOOL; e : (Red, Green, Blue)"


def seen(statements: str, *cycles: Mapping[str, bool | int]) -> Coverage:
    """Run a program once for each cycle with these values; its statements begin in line 2."""
    text = f"PROGRAM PLC_PRG VAR {VARIABLES}; END_VAR\n{statements}\nEND_PROGRAM"
    with collecting(is_detailed=True) as collected:
        bench = IecBench(text, CODESYS)
        for values in cycles:
            for name, value in values.items():
                bench[name] = value
            bench.cycle()
        assert bench.thread.fault is None
        return Coverage(collected.news())


def missed(coverage: Coverage, *kinds: Kind) -> list[str]:
    return [said(place) for place, has_run in coverage.total.places if not has_run and place.kind in kinds]


AND = "y := x AND a > 1;"
HAND = [
    # statements, cycles, conditions that were not, conditions that did not decide
    (AND, [{"x": False, "a": 0}], ["x TRUE", "a > 1 TRUE"], ["x FALSE", "x TRUE", "a > 1 FALSE", "a > 1 TRUE"]),
    (AND, [{"x": True, "a": 2}], ["x FALSE", "a > 1 FALSE"], ["x FALSE", "a > 1 FALSE"]),
    (AND, [{"x": True, "a": 2}, {"x": False}], ["a > 1 FALSE"], ["a > 1 FALSE"]),
    (AND, [{"x": True, "a": 2}, {"x": False}, {"x": True, "a": 1}], [], []),
    ("IF x AND a > 1 THEN ; END_IF", [{"x": True, "a": 2}, {"x": False}, {"x": True, "a": 1}], [], []),
    ("IF z THEN ; ELSIF x OR y THEN ; END_IF", [{"x": True}, {"x": False}, {"y": True}], [], []),
    ("WHILE x AND i < 2 DO i := i + 1; END_WHILE", [{"x": True}, {"x": False, "i": 0}], [], []),
    ("REPEAT i := i + 1; UNTIL x OR i > 2 END_REPEAT", [{}, {"x": True, "i": 0}], [], []),
    ("y := a = 0 OR_ELSE 10 / a > 3;", [{"a": 0}, {"a": 2}, {"a": 5}], [], []),
    ("y := a <> 0 AND_THEN 10 / a > 3;", [{"a": 0}, {"a": 2}], ["10 / a > 3 FALSE"], ["10 / a > 3 FALSE"]),
    ("y := NOT x;", [{}], [], []),
    ("y := x;", [{}], [], []),
    ("y := x XOR z;", [{}], [], []),
]


def names(found: list[str]) -> list[str]:
    return sorted(set(found))


@pytest.mark.parametrize(("statements", "cycles", "conditions", "deciding"), HAND)
def test_conditions(
    statements: str, cycles: list[dict[str, bool | int]], conditions: list[str], deciding: list[str]
) -> None:
    coverage = seen(statements, *cycles)
    assert names(missed(coverage, Kind.CONDITION)) == sorted(conditions)
    assert names(missed(coverage, Kind.DECIDES)) == sorted(f"{one} decides" for one in deciding)


def test_the_same_condition_twice_is_two_conditions() -> None:
    coverage = seen("y := (x AND z) OR (x AND a > 1);", {"x": True, "z": True})
    found = {place.what.rpartition(" ")[0] for place, _ in coverage.total.places if place.kind is Kind.CONDITION}
    assert found == {"x", "z", "x (2)", "a > 1"}


def test_a_decision_of_very_many_conditions_has_no_marks_of_its_own() -> None:
    coverage = seen(f"y := {' OR '.join(['x'] * 2000)};", {})
    assert missed(coverage, *DETAILS) == ["e = Green", "e = Blue"]


STATES = [
    ("e := Green;", [{}], ["e = Blue"]),
    ("IF x THEN e := Blue; END_IF", [{}], ["e = Green", "e = Blue"]),
    ("IF x THEN e := Blue; END_IF", [{"x": True}], ["e = Green"]),
    ("CASE e OF Red: e := Green; Green: e := Blue; END_CASE", [{}, {}], []),
    ("a := a + 1;", [{}, {"e": 2}], ["e = Green"]),
]


@pytest.mark.parametrize(("statements", "cycles", "states"), STATES)
def test_states_of_enumerations(statements: str, cycles: list[dict[str, bool | int]], states: list[str]) -> None:
    assert missed(seen(statements, *cycles), Kind.STATE) == states


def test_lcov_has_mcdc_as_its_manual_writes_it() -> None:
    text = lcov(seen(AND, {"x": True, "a": 2}, {"x": False})).decode()
    rows = {line for line in text.splitlines() if line.startswith("MC")}
    assert rows == {
        "MCDC:2,2,t,1,0,x",
        "MCDC:2,2,f,1,0,x",
        "MCDC:2,2,t,1,1,a > 1",
        "MCDC:2,2,f,0,1,a > 1",
        "MCF:4",
        "MCH:3",
    }


def test_without_the_option_there_are_no_details() -> None:
    with collecting() as collected:
        IecBench(f"PROGRAM PLC_PRG VAR {VARIABLES}; END_VAR\n{AND}\nEND_PROGRAM").cycle()
        assert Coverage(collected.news()).total.count(*DETAILS) == (0, 0)
