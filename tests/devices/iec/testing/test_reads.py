"""A test with a rig computes an expectation only where what it reads has changed, and sees the same."""

from pathlib import Path

import pytest
from st_tests import LAMP_RIG, outcomes, written

from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.testing.case import Outcome
from fieldrig_devices.iec.testing.compiled import compile_tests
from fieldrig_devices.languages.source_file import SourceFile

pytestmark = pytest.mark.lean

LAMP = """\
VAR_GLOBAL presses : UINT; block : BOOL; ramp : REAL; END_VAR
PROGRAM PLC_PRG
VAR switch AT %IX0.0 : BOOL; lamp AT %QX0.0 : BOOL; edge : R_TRIG; late : TON; END_VAR
edge(CLK := switch);
IF edge.Q THEN presses := presses + 1; END_IF
late(IN := switch, PT := T#30ms);
ramp := ramp + 0.25;
lamp := late.Q AND NOT block;
END_PROGRAM
"""
PLACES = """
    switch AT 'wires/switch.on' : BOOL;
    lamp AT 'wires/lamp.on' : BOOL;
    presses AT 'terminal/presses' : UINT;
    block AT 'terminal/block' : BOOL;
    ramp AT 'terminal/ramp' : REAL;
    i : INT := 2;
"""
FUNCTIONS = """FUNCTION Tenfold : REAL
VAR_INPUT x : REAL; END_VAR
Tenfold := 10.0 * x;
END_FUNCTION
FUNCTION_BLOCK Counter
VAR_OUTPUT n : INT; END_VAR
METHOD more : INT
n := n + 1;
more := n;
END_METHOD
END_FUNCTION_BLOCK
"""
BODIES = [
    "switch := TRUE; ASSERT_WITHIN(lamp, T#100ms); ASSERT_EQ(presses, 1);",
    "switch := TRUE; ASSERT_WITHIN(lamp, T#10ms);",
    "switch := TRUE; ASSERT_NEVER(lamp AND presses = 1, T#200ms);",
    "switch := TRUE; ASSERT_STAYS(NOT lamp, T#25ms); ASSERT_NEVER(block, T#50ms); ASSERT_TRUE(lamp);",
    "ASSERT_NEVER(ramp > 5.0, T#2s); ASSERT_TRUE(FALSE);",
    "ASSERT_WITHIN(ABS(ramp - 8.0) < 0.1, T#2s); ASSERT_NEAR(ramp, 8.0, 0.1);",
    "switch := TRUE; ASSERT_UNTIL(NOT lamp, presses = 1 AND ramp > 1.0, T#500ms); ASSERT_EQ(presses, 2);",
    "switch := TRUE; ASSERT_UNTIL(presses = 0, lamp, T#500ms);",
    "ASSERT_WITHIN(Tenfold(ramp) > 80.0, T#2s); ASSERT_NEAR(ramp, 8.0, 0.3);",
    "ASSERT_WITHIN(c.more() > 20, T#2s); ASSERT_NEAR(ramp, 1.0, 0.01);",
    "p := ADR(ramp); ASSERT_WITHIN(p^ > 8.0, T#2s); ASSERT_NEAR(ramp, 8.0, 0.3);",
    "ASSERT_WITHIN(a[i] = 7, T#100ms);",
    "ASSERT_WITHIN(lamp, T#0ms);",
    "ASSERT_STAYS(NOT lamp, T#0ms); ASSERT_FALSE(lamp);",
    "FAULT('terminal', 'power_off'); ASSERT_STAYS(presses = 0, T#50ms); ASSERT_EQ(ramp, 0.0);",
]


def played(folder: Path) -> dict[str, Outcome]:
    return {name: one._replace(wall_s=0, busy_s=0) for name, one in outcomes(folder / "lamp_test.st").items()}


@pytest.mark.long
def test_what_is_not_computed_again_would_be_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "lamp.yaml").write_text(LAMP_RIG)
    further = "c : Counter; p : POINTER TO REAL; a : ARRAY[1..3] OF INT;"
    tests = [
        f"TEST 'number {number}'\nVAR {PLACES} {further} END_VAR\n{body}\nEND_TEST"
        for number, body in enumerate(BODIES)
    ]
    written(tmp_path, lamp=LAMP, lamp_test="\n".join([FUNCTIONS, "RIG 'lamp.yaml' AFTER T#1s;", *tests]))
    chosen = played(tmp_path)
    monkeypatch.setattr("fieldrig_devices.iec.testing.assertions.variables_of", lambda condition: None)
    assert chosen == played(tmp_path)
    assert {len(one.failures) for one in chosen.values()} == {0, 1}


READS = [
    ("x > 1.0 AND NOT b", {"x", "b"}),
    ("ABS(x - 2.0) < 0.5", {"x"}),
    ("REAL_TO_INT(x) = i", {"x", "i"}),
    ("w.3", {"w"}),
    ("TRUE", set[str]()),
    ("Tenfold(x) > 1.0", None),
    ("c.more() > 3", None),
    ("p^ > 1.0", None),
    ("r > 1.0", None),
    ("a[i] = 3", None),
]


@pytest.mark.parametrize(("condition", "reads"), READS)
def test_it_is_known_what_a_condition_reads(condition: str, reads: set[str] | None) -> None:
    own = "x : REAL; b : BOOL; i : INT; w : WORD; c : Counter; a : ARRAY[1..3] OF INT; "
    own += "p : POINTER TO REAL; r : REFERENCE TO REAL;"
    text = f"{FUNCTIONS}TEST 'it' VAR {own} END_VAR\nASSERT_WITHIN({condition}, T#1s);\nEND_TEST"
    (assertion,) = compile_tests([SourceFile("it_test.st", text)], EDITION_3).assertions
    assert assertion.reads == reads
