"""EN and ENO of calls in Structured Text and Instruction List, and what networks make of them (edition 3)."""

import pytest
from exchange_documents import block, pou, sink, source, tc6
from iec_check import messages
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect

HALF = """
FUNCTION Half : INT
VAR_INPUT a : INT; END_VAR
VAR_OUTPUT odd : BOOL; END_VAR
Half := a / 2;
odd := a MOD 2 <> 0;
ENO := NOT odd;
END_FUNCTION
"""
LAMP = """
FUNCTION_BLOCK Lamp
VAR_INPUT on : BOOL; END_VAR
VAR_OUTPUT lit : BOOL; END_VAR
VAR count : INT; END_VAR
METHOD PUBLIC Times : INT
VAR_INPUT factor : INT; END_VAR
    count := count + 1;
    Times := count * factor;
    ENO := factor > 0;
END_METHOD
lit := on;
END_FUNCTION_BLOCK
"""


def run(declarations: str, body: str, before: str = HALF + LAMP) -> IecBench:
    bench = IecBench(before + program(declarations, body), EDITION_3)
    bench.cycle()
    assert bench.thread.fault is None, bench.thread.fault
    return bench


def test_a_method_has_an_eno_of_its_own() -> None:
    bench = run(
        "l : Lamp; a, b : INT; okA, okB : BOOL; okC : BOOL := TRUE;",
        """l(on := TRUE);
        a := l.Times(5, ENO => okA);
        b := l.Times(0, ENO => okB) + 1;
        l.Times(7, EN := okB, ENO => okC);""",
    )
    assert [bench[name] for name in ("a", "b", "okA", "okB", "okC", "l.lit")] == [5, 1, True, False, False, True]
    assert bench.compiled.program.pous["lamp"].eno is None, "a name that only the method uses"


def test_the_eno_of_an_instance_is_that_of_its_last_call() -> None:
    bench = run(
        "l, never : Lamp; first, second, third : BOOL;",
        """first := l.ENO;
        l();
        second := l.ENO AND NOT never.ENO;
        l(EN := FALSE);
        third := NOT l.ENO;""",
    )
    assert [bench[name] for name in ("first", "second", "third")] == [False, True, True]
    assert bench["never.ENO"] is False


def test_arguments_are_not_evaluated_without_en() -> None:
    """Otherwise the index would stop the task."""
    bench = run(
        "t : ARRAY[1..3] OF INT; l : Lamp; i : INT := 9; x : INT := 4; ok : BOOL;",
        """x := Half(t[i], EN := i <= 3, ENO => ok);
        x := x + Half(t[i], EN := i <= 3);
        l(EN := i <= 3, on := t[i] > 0);""",
    )
    assert bench["x"] == 4


def test_an_array_that_a_function_returns_has_its_start_values_without_en() -> None:
    before = """
    TYPE Pair : ARRAY[1..2] OF INT := [7, 8]; END_TYPE
    FUNCTION Both : Pair
    VAR_INPUT a : INT; END_VAR
    Both[1] := a; Both[2] := a;
    END_FUNCTION
    FUNCTION Sum : INT
    VAR_INPUT p : Pair; END_VAR
    Sum := p[1] + p[2];
    END_FUNCTION
    """
    bench = run(
        "a, b : INT; p : Pair;", "a := Sum(Both(3)); b := Sum(Both(3, EN := a = 0)); p := Both(1, EN := FALSE);", before
    )
    assert [bench[name] for name in ("a", "b", "p[1]", "p[2]")] == [6, 15, 7, 8]


def test_eno_in_loops_and_elements() -> None:
    bench = run(
        "l : ARRAY[1..4] OF Lamp; ok : ARRAY[1..4] OF BOOL; i, n : INT;",
        """FOR i := 1 TO 4 DO
            l[i](EN := i MOD 2 = 0, on := TRUE, NOT ENO => ok[i]);
            n := n + Half(i * 3, EN := i > 1, ENO => ok[5 - i]);
        END_FOR;""",
    )
    # Half of 6, 9 and 12; ok[5 - i] is written after ok[i]: i = 1 FALSE, 2 TRUE, 3 FALSE, 4 TRUE.
    assert bench["n"] == 3 + 4 + 6
    assert [bench[f"l[{n}].lit"] for n in range(1, 5)] == [False, True, False, True]
    assert [bench[f"ok[{n}]"] for n in range(1, 5)] == [True, False, True, False]


def test_a_drawn_block_does_what_the_same_call_does() -> None:
    own = (
        '<pou name="HALF" pouType="function"><interface><returnType><INT/></returnType><inputVars><variable name="a">'
        "<type><INT/></type></variable></inputVars></interface><body><ST><xhtml:p>"
        "HALF := a / 2; ENO := a MOD 2 = 0;</xhtml:p></ST></body></pou>"
    )
    document = tc6(
        pou(
            "<FBD>"
            + source("1", "on")
            + source("2", "a")
            + block("3", "HALF", {"EN": "1", "a": "2"}, "ENO OUT")
            + sink("4", "c", "3.OUT")
            + sink("5", "ok", "3.ENO")
            + "</FBD>",
            variables={"on": "BOOL", "a": "INT", "c": "INT", "ok": "BOOL"},
        )
    ).replace("<pous>", f"<pous>{own}")
    drawn = IecBench(document, EDITION_3, main="P")
    written = IecBench(
        HALF + program("on, ok : BOOL; a, c : INT;", "c := Half(EN := on, a := a, ENO => ok);"), EDITION_3
    )
    seen = []
    for on, a in ((True, 8), (True, 9), (False, 20), (True, 20)):
        for bench in (drawn, written):
            bench["on"], bench["a"] = on, a
            bench.cycle()
        assert [drawn[name] for name in ("c", "ok")] == [written[name] for name in ("c", "ok")]
        seen.append((drawn["c"], drawn["ok"]))
    assert seen == [(4, True), (4, False), (4, False), (10, True)]


def test_a_division_with_en_alone_still_stops_the_task() -> None:
    bench = IecBench(program("a, zero : INT;", "a := DIV(EN := zero = 0, 5, zero);"), EDITION_3)
    bench.cycle()
    assert bench.thread.fault is not None
    assert bench.thread.fault.code == "division"


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("n := Half(4, EN := 5);", "the number 5 is no BOOL"),
        ("n := Half(4, EN := b, EN := b);", "EN is given twice; expected EN := condition"),
        ("n := Half(4, EN => b);", "EN is an input of every call; expected EN := condition"),
        ("l(ENO := b);", "ENO is an output of every call; expected ENO => target"),
        ("l(ENO => n);", "n is an INT; expected a BOOL for ENO"),
        ("l(ENO => TRUE);", "TRUE is a value"),
        ("l.ENO := b;", "l.ENO is an output and only its block writes it"),
        ("EN := b;", "EN is a constant; expected a variable that may be written here"),
        ("b := box.ENO;", "Box has no variable ENO"),
        ("n := ADR(n, EN := b);", "ADR with 2 arguments"),
        ("n := ABS(ENO => b);", "ABS with nothing; expected one number"),
    ],
)
def test_a_wrong_en_or_eno_has_one_message(body: str, expected: str) -> None:
    box = "CLASS Box END_CLASS "
    found = refused(HALF + LAMP + box + program("n : INT; b : BOOL; l : Lamp; box : Box;", body), EDITION_3)
    assert sum("note:" not in message for message in found) == 1, found
    assert any(expected in message for message in found), found


def test_the_eno_of_a_block_that_others_extend_is_not_read_by_a_reference() -> None:
    """Each of them has it elsewhere; the call itself gives it, as in `enabled-by-reference.st`."""
    text = "FUNCTION_BLOCK Base ENO := FALSE; END_FUNCTION_BLOCK FUNCTION_BLOCK Far EXTENDS Base END_FUNCTION_BLOCK "
    peek = "FUNCTION Peek : BOOL VAR_IN_OUT b : {}; END_VAR b(); Peek := b.ENO; END_FUNCTION "
    found = refused(text + peek.format("Base") + program("", ""), EDITION_3)
    assert any("Base has no variable ENO" in message for message in found), found
    bench = IecBench(text + peek.format("Far") + program("f : Far; ok : BOOL := FALSE;", "ok := Peek(f);"), EDITION_3)
    bench.cycle()
    assert bench["ok"] is True


@pytest.mark.parametrize("dialect", [EPAS_4, CODESYS], ids=lambda dialect: dialect.name)
@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("n := Half(EN := b, a := 4);", "Half has no input EN; expected a"),
        ("n := Half(a := 4, ENO => b);", "Half has no output ENO; expected no output"),
        ("b := ENO;", "ENO is not declared"),
    ],
)
def test_the_other_dialects_name_the_one_that_has_them(dialect: Dialect, body: str, expected: str) -> None:
    half = "FUNCTION Half : INT VAR_INPUT a : INT; END_VAR Half := a / 2; END_FUNCTION "
    found = refused(half + program("n : INT; b : BOOL;", body), dialect)
    (message,) = [message for message in found if expected in message]
    assert "EN and ENO of every call are known in the dialect edition-3" in message


def test_blocks_of_the_other_dialects_keep_an_input_en_of_their_own() -> None:
    gate = """FUNCTION_BLOCK Gate VAR_INPUT EN : BOOL; END_VAR VAR_OUTPUT ENO, off : BOOL; END_VAR
    off := NOT EN; END_FUNCTION_BLOCK """
    bench = IecBench(gate + program("g : Gate; off, eno : BOOL;", "g(EN := FALSE, off => off, ENO => eno);"), CODESYS)
    bench.cycle()
    assert (bench["off"], bench["eno"]) == (True, False)


def test_rtc_keeps_its_own_en_in_edition_3() -> None:
    """The library declares it."""
    text = program("r : RTC; ok : BOOL;", "r(EN := TRUE, PDT := DT#2026-01-01-0:0, ENO => ok);")
    assert not messages(text, dialect=EDITION_3)
