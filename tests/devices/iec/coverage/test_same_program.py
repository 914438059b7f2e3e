"""Marks change nothing of a program but that they are passed: its results, its faults and its time are the same."""

import re
from contextlib import nullcontext
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import IecBench

from fieldrig.coverage.collecting import collecting
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.types import Value
from fieldrig_devices.languages.writer import Build

FILES = sorted((Path(__file__).parents[1] / "programs").glob("*.st"))
HEAD = re.compile(r"\(\* dialects: (\w[\w-]*)")
LOOPS = """\
PROGRAM PLC_PRG VAR a, b, i : INT; END_VAR
FOR i := 1 TO 3 DO IF i = 2 THEN CONTINUE; END_IF a := a + i; END_FOR
WHILE b < 3 DO b := b + 1; IF b = 2 THEN EXIT; END_IF END_WHILE
CASE a OF 1: b := 1; 2, 3: b := 2; END_CASE
END_PROGRAM
"""


def played(text: str, dialect: str, cycles: int, *, is_covered: bool) -> tuple[dict[str, Value], str, int, int]:
    """Return the values, the fault, the processor time and the size of the code of a program."""
    with collecting(is_detailed=True) if is_covered else nullcontext():
        bench = IecBench(text, DIALECTS[dialect])
        used = 0
        for number in range(cycles):
            bench.host.ms = number * 20
            used += bench.cycle()
    return bench.values(), str(bench.thread.fault), used, bench.compiled.code_size


SAMPLE = sorted({*FILES[::6], *(file for file in FILES if "enumeration" in file.stem)})


@pytest.mark.parametrize("file", SAMPLE, ids=lambda file: file.stem)
def test_small_programs_have_the_same_results_and_take_the_same_time(file: Path) -> None:
    text = file.read_text(encoding="ascii")
    head = HEAD.match(text)
    assert head is not None
    plain, marked = (played(text, head[1], 3, is_covered=on) for on in (False, True))
    assert str(plain) == str(marked)  # as texts, because NaN is not equal to itself


NAMES = st.sampled_from(["a", "b", "c"])
SINGLE = st.builds("{} {} {}".format, NAMES, st.sampled_from(["<", "=", ">"]), st.integers(-2, 4))
CONDITIONS = st.recursive(
    SINGLE,
    lambda inner: (
        st.builds("NOT ({})".format, inner)
        | st.builds("({} {} {})".format, inner, st.sampled_from(["AND", "OR", "XOR"]), inner)
    ),
    max_leaves=4,
)
SIMPLE = st.builds("{} := {} + {};".format, NAMES, NAMES, st.integers(-3, 3))
COUNTED = st.just("n := n + 1; m := m MOD 3 + 1; IF n > 20 THEN RETURN; END_IF")
"""The begin of every loop: `n` is never reset within a cycle, so a loop within another ends too."""
LEAVING = st.sampled_from(["IF a = b THEN EXIT; END_IF", "IF a > c THEN CONTINUE; END_IF", "EXIT;", "RETURN;"])


def compound(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    suite = st.lists(inner, max_size=3).map(" ".join)
    looped = st.tuples(suite, LEAVING, suite).map(" ".join) | suite
    return st.one_of(
        st.builds("IF {} THEN {} END_IF".format, CONDITIONS, suite),
        st.builds("IF {} THEN {} ELSIF {} THEN {} ELSE {} END_IF".format, CONDITIONS, suite, CONDITIONS, suite, suite),
        st.builds(
            "CASE {} OF -1: {} 0, 2..3: {} END_CASE".format, NAMES, suite.map(";{}".format), suite.map(";{}".format)
        ),
        st.builds("FOR i := {} TO {} DO {} {} EXIT; END_FOR".format, st.integers(0, 2), NAMES, COUNTED, looped),
        st.builds("WHILE {} DO {} {} END_WHILE".format, CONDITIONS, COUNTED, looped),
        st.builds("REPEAT {} {} UNTIL m > 2 END_REPEAT".format, COUNTED, suite),
    )


STATEMENTS = st.lists(st.recursive(SIMPLE, compound, max_leaves=8), min_size=1, max_size=4).map("\n".join)


@pytest.mark.long
@settings(deadline=None, max_examples=15)
@given(STATEMENTS)
def test_any_program_has_the_same_results_and_takes_the_same_time(statements: str) -> None:
    text = f"PROGRAM PLC_PRG VAR a, b, c, i, n, m : INT; END_VAR\nn := 0; m := 0; {statements}\nEND_PROGRAM"
    plain, marked = (played(text, "edition-3", 2, is_covered=on) for on in (False, True))
    assert plain == marked


def test_the_code_has_no_marks_unless_coverage_is_wanted() -> None:
    def code() -> str:
        return IecBench(LOOPS, DIALECTS["edition-3"]).runtime.code.source(Build.FAST)

    before = code()
    with collecting():
        marked = code()
    assert "hit[" not in before
    assert marked.count("hit[") == 15
    assert code() == before


def test_a_program_of_straight_lines_differs_by_its_mark_only() -> None:
    text = "PROGRAM PLC_PRG VAR a : INT; END_VAR a := a + 1; END_PROGRAM"
    before = IecBench(text).runtime.code.source(Build.FAST)
    with collecting():
        marked = IecBench(text).runtime.code.source(Build.FAST)
    before = before.replace("return 2, 1, ", "return 2, 2, ")  # the number of the last instruction
    assert [line for line in marked.splitlines() if "hit[" not in line] == before.splitlines()
