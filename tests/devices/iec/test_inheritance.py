"""EXTENDS of function blocks and structures (edition 3)."""

import pytest
from iec_check import messages
from iec_program import IecBench

from fieldrig_devices.iec.dialect import EDITION_3

BLOCKS = """
FUNCTION_BLOCK Base
VAR_INPUT x : INT; END_VAR
VAR_OUTPUT n : INT := 5; END_VAR
n := n + x;
Log();

METHOD Weight : INT
    Weight := 1;
END_METHOD

METHOD Total : INT
VAR_INPUT count : INT; END_VAR
    Total := count * Weight();
END_METHOD

ACTION Log:
    n := n + 1;
END_ACTION
END_FUNCTION_BLOCK

FUNCTION_BLOCK Middle EXTENDS Base
VAR m : INT; END_VAR
SUPER^(x := 10);
m := m + 1;

METHOD Weight : INT
    Weight := SUPER^.Weight() + 10;
END_METHOD
END_FUNCTION_BLOCK

FUNCTION_BLOCK Top EXTENDS Middle
VAR_OUTPUT t : INT; END_VAR
SUPER^();
t := m + n;

METHOD Weight : INT
    Weight := SUPER^.Weight() + 100;
END_METHOD

METHOD Plain : INT
    Plain := SUPER^.Total(1) + THIS^.n;
END_METHOD

ACTION Log:
    n := n + 1000;
END_ACTION
END_FUNCTION_BLOCK
"""


def bench_of(declarations: str, body: str, before: str = BLOCKS) -> IecBench:
    bench = IecBench(f"PROGRAM PLC_PRG\nVAR\n{declarations}\nEND_VAR\n{body}\nEND_PROGRAM\n{before}", EDITION_3)
    bench.cycle()
    assert bench.thread.fault is None, bench.thread.fault
    return bench


@pytest.mark.parametrize(("kind", "weight"), [("Base", 1), ("Middle", 11), ("Top", 111)])
def test_inherited_code_calls_the_methods_that_override_others(kind: str, weight: int) -> None:
    bench = bench_of(f"block : {kind}; weight, total : INT;", "weight := block.Weight();\ntotal := block.Total(3);")
    assert (bench["weight"], bench["total"]) == (weight, 3 * weight)


def test_bodies_actions_and_variables_are_inherited() -> None:
    bench = bench_of("a : Base; b : Middle; c : Top; plain : INT;", "a(x := 1);\nb();\nc();\nplain := c.Plain();")
    assert [bench[name] for name in ("a.n", "b.n", "b.m", "b.x")] == [7, 16, 1, 10]
    assert [bench[name] for name in ("c.n", "c.t", "c.m", "plain")] == [1015, 1016, 1, 1126]


def test_a_structure_begins_with_the_components_of_the_one_that_it_extends() -> None:
    types = """
    TYPE Third EXTENDS Second : STRUCT c : INT; END_STRUCT END_TYPE
    TYPE First : STRUCT a : INT := 3; END_STRUCT END_TYPE
    TYPE Second EXTENDS First : STRUCT b : INT := 4; END_STRUCT END_TYPE
    """
    bench = bench_of("t : Third := (c := 7); sum, size : INT;", "sum := t.a + t.b + t.c;\nsize := SIZEOF(t);", types)
    assert (bench["sum"], bench["size"]) == (14, 6)


WITH_X = "FUNCTION_BLOCK a VAR x : INT; END_VAR END_FUNCTION_BLOCK"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("FUNCTION_BLOCK a EXTENDS bb END_FUNCTION_BLOCK", "bb is not declared; a function block that a extends"),
        (
            "FUNCTION_BLOCK a EXTENDS b END_FUNCTION_BLOCK FUNCTION b : INT b := 1; END_FUNCTION",
            "b is a FUNCTION; a function block that a extends",
        ),
        ("FUNCTION_BLOCK a EXTENDS a END_FUNCTION_BLOCK", "a extends itself; another function block"),
        (
            f"{WITH_X.replace('FUNCTION_BLOCK a', 'FUNCTION_BLOCK b EXTENDS a', 1)}\n{WITH_X}",
            "x is declared in line 2 already; another name, or one declaration (PD-350)",
        ),
        (
            "FUNCTION_BLOCK a SUPER^(); END_FUNCTION_BLOCK",
            "SUPER^() without EXTENDS; a call in a function block that extends another one",
        ),
        ("TYPE t EXTENDS t : STRUCT a : INT; END_STRUCT END_TYPE", "t is no structure that can be extended; the name"),
        ("TYPE t EXTENDS u : STRUCT a : INT; END_STRUCT END_TYPE", "the structure u is not declared; the name"),
        (
            "TYPE u : UNION a : INT; END_UNION END_TYPE TYPE t EXTENDS u : STRUCT b : INT; END_STRUCT END_TYPE",
            "u is no structure that can be extended; the name",
        ),
        (
            "TYPE s : STRUCT a : INT; END_STRUCT END_TYPE TYPE t EXTENDS s : UNION b : INT; END_UNION END_TYPE",
            "s is no union that can be extended; the name",
        ),
    ],
)
def test_what_cannot_be_extended_is_refused(text: str, expected: str) -> None:
    found = [message.partition(" ")[2] for message in messages(text, dialect=EDITION_3)]
    assert expected in "\n".join(found), found


def test_a_mistake_in_inherited_code_is_reported_once() -> None:
    text = (
        "FUNCTION_BLOCK a METHOD m y := 1; END_METHOD END_FUNCTION_BLOCK FUNCTION_BLOCK b EXTENDS a END_FUNCTION_BLOCK"
    )
    assert len(messages(text, dialect=EDITION_3)) == 1
