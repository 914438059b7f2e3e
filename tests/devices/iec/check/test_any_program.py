"""No source text makes the checker raise: programs with words deleted, repeated, exchanged and replaced."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_check import ConfiguredHost, messages

from fieldrig_devices.iec.check import check
from fieldrig_devices.iec.dialect import EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.library.selection import needed
from fieldrig_devices.iec.library.sources import sources
from fieldrig_devices.iec.parser import parse

SAMPLE = """
TYPE Color : (red, green := 4, blue); END_TYPE
TYPE Point : STRUCT x, y : REAL := 1.5; c : Color; next : POINTER TO Point; END_STRUCT END_TYPE
TYPE Small : INT(0..10) := 3; END_TYPE
TYPE Line : ARRAY[1..n] OF Point; END_TYPE
VAR_GLOBAL CONSTANT n : INT := 2 * half; half : INT := 3; END_VAR
VAR_GLOBAL RETAIN g : DINT := 5; w AT %MW5 : WORD; b AT %QX3.1 : BOOL; END_VAR
FUNCTION Scale : REAL
VAR_INPUT value : REAL; factor : REAL := 2.0; END_VAR VAR_IN_OUT count : INT; END_VAR
count := count + 1;
Scale := value * factor;
END_FUNCTION
FUNCTION_BLOCK Counter
VAR_INPUT up : BOOL; step : INT := 1; END_VAR VAR_OUTPUT q : INT; END_VAR VAR_IN_OUT total : INT; END_VAR
VAR last : BOOL; t : TON; END_VAR VAR_TEMP h : INT; END_VAR VAR_EXTERNAL g : DINT; END_VAR
IF up AND NOT last THEN q := q + step; ELSIF q > 100 THEN Clear; ELSE RETURN; END_IF
last := up; h := q; total := total + h; g := g + total;
t(IN := up, PT := T#1s, Q => last);
ACTION Clear : q := 0; END_ACTION
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR c : ARRAY[1..3] OF Counter;
p : Point := (x := 2.5, c := green); l : Line; i : Small; s : STRING(20) := 'abc'; END_VAR
VAR k : INT; r : REAL; pt : POINTER TO Point; d : DWORD;
x AT %IX5.0 : BOOL; m : ARRAY[1..2, 1..3] OF INT := 6(1); END_VAR
FOR k := 1 TO 3 BY 1 DO c[k](up := x, total := k, q => i); IF k = 2 THEN EXIT; END_IF END_FOR
r := Scale(value := p.x, count := k) + SQRT(r) / 3;
pt := ADR(p); pt^.y := pt^.next^.x; d.3 := TRUE; %MW7 := w AND 16#FF;
CASE p.c OF red: i := 3; green, blue: p.c := red; ELSE ; END_CASE
WHILE r > 1.0 DO r := r / 2.0; END_WHILE REPEAT m[1, 2] := m[1, 3] MOD 7; UNTIL k >= 3 OR x END_REPEAT
s := CONCAT(s, DINT_TO_STRING(g)); k := SIZEOF(Line) + MAX(k, 3, n) + LEN(s);
l[k].c := SEL(x, red, blue); g := _Axis_10;
c[1].Clear(); b := c[2].q > Axis_10.AxisState AND PacDriveM.Timer1 < 5; Axis_10.Enable := b;
END_PROGRAM
CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 3);
PROGRAM a WITH T : PLC_PRG; END_RESOURCE END_CONFIGURATION
"""

WORDS = re.findall(r"\s+|[A-Za-z_][\w#]*|%\w+(?:\.\d+)?|:=|=>|\.\.|<>|>=|<=|\d[\w.#]*|'[^']*'|.", SAMPLE)


def test_the_sample_itself_has_no_mistake() -> None:
    assert messages(SAMPLE) == []


@st.composite
def spoiled(draw: st.DrawFn) -> str:
    words = list(WORDS)
    for _ in range(draw(st.integers(1, 6))):
        place, other = draw(st.integers(0, len(words) - 1)), draw(st.integers(0, len(words) - 1))
        match draw(st.sampled_from(["delete", "repeat", "exchange", "replace"])):
            case "delete":
                words[place] = ""
            case "repeat":
                words[place] += " " + words[place]
            case "exchange":
                words[place], words[other] = words[other], words[place]
            case _:
                words[place] = words[other]
    return "".join(words)


BOTH = pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3], ids=["epas-4", "edition-3"])


@BOTH
def test_the_whole_library_has_no_mistake(dialect: Dialect) -> None:
    library = [parse(text, name, dialect)[0] for name, text in sources(dialect.name)]
    _, mistakes = check(library, ConfiguredHost(), dialect)
    assert mistakes == []


@pytest.mark.long
@BOTH
def test_no_program_makes_the_checker_raise(dialect: Dialect) -> None:
    library = [parse(text, name, dialect)[0] for name, text in sources(dialect.name)]

    @settings(max_examples=60, deadline=None)
    @given(spoiled())
    def survive(text: str) -> None:
        unit, _ = parse(text, "spoiled.st", dialect)
        used = needed(library, [unit], [text])
        _, mistakes = check([*used, unit], ConfiguredHost(), dialect)
        lines = text.count("\n") + 1
        assert [found for found in mistakes if not 1 <= found.line <= lines or found.column < 1] == []
        assert {found.file for found in mistakes} <= {"spoiled.st"}

    survive()
