"""Whatever a program contains, checking and compiling it ends in a program or in messages."""

import contextlib

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from iec_check import ConfiguredHost
from iec_trees import UNITS

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import check
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.mistakes import CompileError, Mistake
from fieldrig_devices.languages.source_file import SourceFile

PROGRAM = """
TYPE Form : STRUCT a : ARRAY[1..3] OF INT; b : BOOL; END_STRUCT END_TYPE
FUNCTION Twice : INT VAR_INPUT x : INT; END_VAR
LD x
MUL 2
ST Twice
END_FUNCTION
FUNCTION_BLOCK Counter VAR_INPUT go : BOOL; END_VAR VAR_OUTPUT n : INT; END_VAR
VAR t : TON; r : BOOL; f : Form; END_VAR
LD n
ADD ( 1
  MUL ( 2
  SUB 1 )
)
Twice
ST n
GT 7
JMPC there
CALC t(IN := go, PT := T#3s)
there: LD go
S r
RETCN
LD n
EXPT 2
ST f.a[1]
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR c : Counter; out : BOOL; x : INT; r : REAL; END_VAR
INITIAL_STEP Wait: out(N); run(SD, T#5s); END_STEP
STEP Work: run(R); ENTRY x := Twice(x) + 1; END_ENTRY ACTIVE LD x
 ADD 1
 ST x
 END_ACTIVE EXIT c(go := TRUE); END_EXIT END_STEP
TRANSITION FROM Wait TO Work := x > 3 AND Wait.t > T#1s; END_TRANSITION
TRANSITION FROM (Work) TO (Wait) := TRUE; END_TRANSITION
ACTION run: r := r * 2.0; c.go := x = 3; END_ACTION
END_PROGRAM
"""
MORE = ["CAL", "LDN", "JMP", "RET", "NOT", "(", ")", "REAL", "STRING", "'a'", "1.5", "^", "%MW3"]
WORDS = sorted({*PROGRAM.split(), *MORE})
OF_EDITION_3 = """
FUNCTION Sum : INT
VAR_INPUT scale : INT := 1; END_VAR
VAR_IN_OUT a : ARRAY[*, *] OF INT; END_VAR
VAR i, j : INT; END_VAR
FOR i := LOWER_BOUND(a, 1) TO UPPER_BOUND(a, 1) DO
Sum := Sum + Row(a[i]) * scale;
END_FOR;
ENO := Sum < 100 AND EN;
END_FUNCTION
FUNCTION Row : INT
VAR_INPUT a : ARRAY[*] OF INT; END_VAR
VAR_OUTPUT least : INT; END_VAR
Row := a[UPPER_BOUND(a, 1)]; least := DIV(Row, a[0], ENO => ENO);
END_FUNCTION
FUNCTION Clear
VAR_OUTPUT a : ARRAY[*] OF INT; END_VAR
a[LOWER_BOUND(a, 1)] := 0;
END_FUNCTION
CLASS Box
VAR t : ARRAY[0..1, 0..2] OF INT; END_VAR
METHOD PUBLIC Fill : BOOL VAR_IN_OUT b : ARRAY[*] OF INT; END_VAR
Clear(a => b); Fill := Sum(EN := b[1] > 0, a := t, ENO => ENO) > 3; END_METHOD
END_CLASS
FUNCTION_BLOCK Gate
VAR_INPUT EN : BOOL := TRUE; x : INT; END_VAR
VAR_IN_OUT list : ARRAY[*] OF INT; END_VAR
VAR_OUTPUT ENO : BOOL; y : INT; END_VAR
y := x + list[x]; ENO := y < 9;
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR g : Gate; box : Box; t : TON; c : ARRAY[0..3] OF INT; ok : BOOL; n : INT; r : REAL; END_VAR
g(EN := n = 0, x := 1, list := c, NOT ENO => ok);
n := 1 + Row(c, EN := ok, ENO => ok, least => n);
r := SQRT(EN := ok, IN := 4.0) + MOD(n, 3, ENO => ok);
ok := AND(g.ENO, t.Q, box.Fill(c, EN := FALSE));
t(IN := ok, ENO => ok);
END_PROGRAM
"""
WORDS_OF_EDITION_3 = sorted({*OF_EDITION_3.split(), "ARRAY[*]", "EN", "ENO", "=>", ":=", "a", "[", "*"})


def compiled(text: str, dialect: Dialect = EPAS_4) -> None:
    compile_project([SourceFile("any.st", text)], StandaloneHost(VirtualClock()), dialect)


@pytest.mark.parametrize(
    "statement",
    ["r := 1e5000;", "r := REAL#1e5000;", f"s := CONCAT({', '.join(['s'] * 3_000)});"],
    ids=["a number that is too large", "a typed number that is too large", "a function with 3,000 arguments"],
)
def test_an_odd_statement_compiles_or_has_messages(statement: str) -> None:
    with contextlib.suppress(CompileError):
        compiled(f"PROGRAM PLC_PRG VAR r : REAL; s : STRING; END_VAR {statement} END_PROGRAM")


def mistakes_of(text: str, dialect: Dialect = EPAS_4) -> list[Mistake]:
    try:
        compiled(text, dialect)
    except CompileError as error:
        return error.mistakes
    return []


@pytest.mark.parametrize("condition", ["b := 5", "b AND_THEN 5"])
def test_what_follows_from_a_repaired_condition_has_a_place(condition: str) -> None:
    text = f"PROGRAM PLC_PRG VAR b : BOOL; END_VAR IF {condition} THEN b := FALSE; END_IF; END_PROGRAM"
    found = [mistake for mistake in mistakes_of(text) if not mistake.is_note]
    assert [(mistake.line, mistake.column) for mistake in found] == [(1, text.index(condition.split()[1]) + 1)] * 2


def test_the_program_that_is_damaged_below_compiles() -> None:
    compiled(PROGRAM)
    compiled(OF_EDITION_3, EDITION_3)


@pytest.mark.long
@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.integers(0, len(PROGRAM)), st.integers(0, 20), st.lists(st.sampled_from(WORDS), max_size=3).map(" ".join))
def test_a_damaged_program_compiles_or_has_messages(start: int, length: int, inserted: str) -> None:
    text = f"{PROGRAM[:start]}{inserted}{PROGRAM[start + length :]}"
    assert all(mistake.line for mistake in mistakes_of(text) if not mistake.is_note)


@pytest.mark.long
@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.integers(0, len(OF_EDITION_3)),
    st.integers(0, 20),
    st.lists(st.sampled_from(WORDS_OF_EDITION_3), max_size=3).map(" ".join),
)
def test_a_damaged_program_of_edition_3_compiles_or_has_messages(start: int, length: int, inserted: str) -> None:
    text = f"{OF_EDITION_3[:start]}{inserted}{OF_EDITION_3[start + length :]}"
    assert all(mistake.line for mistake in mistakes_of(text, EDITION_3) if not mistake.is_note)


@pytest.mark.long
@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(UNITS, st.sampled_from([EPAS_4, EDITION_3]))
def test_any_tree_can_be_checked(unit: tree.Unit, dialect: Dialect) -> None:
    check([unit], ConfiguredHost(), dialect)
