"""Properties of programs over all sequences of inputs, and values of all types."""

import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS
from fieldrig.errors import ArgumentError, UnmetError, UsageError
from fieldrig.programs import ProgramBench, program

LIFT = """\
FUNCTION_BLOCK Lift
VAR_INPUT up, down, stop : BOOL; speed : INT(0..100); END_VAR
VAR_OUTPUT motor, brake : BOOL; END_VAR
VAR release : TON; END_VAR
release(IN := up AND NOT stop, PT := T#30ms);
IF release.Q THEN motor := TRUE; END_IF
IF down THEN motor := FALSE; END_IF
brake := stop OR NOT motor;
END_FUNCTION_BLOCK
"""
TYPES = [
    *("BOOL", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT"),
    *("REAL", "LREAL", "TIME", "LTIME", "DATE", "LDATE", "TOD", "LTOD", "DT", "LDT"),
    *(
        "STRING",
        "STRING(3)",
        "WSTRING(5)",
        "INT(-3..7)",
        "Mode",
        "Pair",
        "Both",
        "ARRAY[1..3] OF Pair",
        "ARRAY[0..1, 0..2] OF INT",
    ),
]
DECLARED = """\
TYPE
Mode : (IDLE := 3, RUNNING := 7);
Pair : STRUCT number : UINT; mode : Mode; END_STRUCT;
Both : STRUCT pair : Pair; times : ARRAY[0..1] OF TIME; END_STRUCT;
END_TYPE
"""


@pytest.fixture
def plc(tmp_path: Path) -> ProgramBench:
    (tmp_path / "lift.st").write_text(LIFT)
    return program(tmp_path / "lift.st", dialect="edition-3")


def failure(plc: ProgramBench, **options: Any) -> list[str]:
    with pytest.raises(UnmetError) as caught:
        plc.for_all(**options)
    return [caught.value.what, *caught.value.remedy.splitlines()]


def noted(values: list[Any], value: Any) -> bool:
    values.append(value)
    return True


def test_what_breaks_a_property_is_made_short(plc: ProgramBench) -> None:
    lift = plc.block("Lift")
    told = failure(plc, block=lift, never=lambda: lift.motor and lift.brake)
    assert told[:3] == ["the condition held at 40 ms", "up = True; 4 cycles", "stop = True; 1 cycle"]
    assert any("Lift.motor = TRUE since T#30ms" in line for line in told)


def test_a_property_that_holds_is_tried_in_all_examples(plc: ProgramBench) -> None:
    lift, begun = plc.block("Lift"), list[int]()
    plc.for_all(
        ["up", "down"],
        block=lift,
        always=lambda: noted(begun, plc.now_ns) and lift.brake is not lift.motor,
        examples=30,
        every=1 * MS,
    )
    assert begun.count(0) == 30


def test_strategies_narrow_the_values(plc: ProgramBench) -> None:
    lift, seen = plc.block("Lift"), list[Any]()
    plc.for_all({"speed": st.integers(3, 5), "up": None}, block=lift, always=lambda: noted(seen, lift.speed))
    assert {*seen} == {0, 3, 4, 5}


def test_a_seed_tries_others(plc: ProgramBench) -> None:
    lift = plc.block("Lift")

    def tried(seed: int | None) -> list[Any]:
        seen: list[Any] = []
        plc.for_all(block=lift, always=lambda: noted(seen, lift.speed), examples=5, seed=seed)
        return seen

    assert tried(None) == tried(None)
    assert tried(1) == tried(1) != tried(2)


@pytest.mark.long
def test_tasks_run_between_the_inputs(tmp_path: Path) -> None:
    (tmp_path / "p.st").write_text(
        "PROGRAM P\nVAR go : BOOL; count, limit : INT; END_VAR\n"
        "IF go THEN count := count + 1; END_IF\nIF count > 5 THEN count := 0; END_IF\nEND_PROGRAM\n"
        "CONFIGURATION C RESOURCE R ON Controller TASK T(INTERVAL := T#10ms, PRIORITY := 1); PROGRAM P1 WITH T : P;\n"
        "END_RESOURCE END_CONFIGURATION\n"
    )
    plc = program(tmp_path / "p.st", dialect="edition-3")
    told = failure(plc, inputs=["P.go"], never=lambda: plc["P.count"] == 4)
    assert told[1].startswith("P.go = True; ")
    plc.for_all(["P.go"], never=lambda: plc["P.count"] == 7, examples=20)


def test_a_fault_of_the_program_is_a_failure(tmp_path: Path) -> None:
    (tmp_path / "d.st").write_text(
        "FUNCTION_BLOCK D\nVAR_INPUT n : INT := 1; END_VAR\nVAR q : INT; END_VAR\nq := 10 / n;\nEND_FUNCTION_BLOCK\n"
    )
    plc = program(tmp_path / "d.st", dialect="edition-3")
    what, step, *_ = failure(plc, block=plc.block("D"), always=lambda: True)
    assert "division by zero" in what.lower(), what
    assert step == "n = 0; 1 cycle"


@pytest.mark.parametrize("kind", TYPES)
def test_each_type_has_values_that_it_keeps(tmp_path: Path, kind: str) -> None:
    (tmp_path / "p.st").write_text(f"{DECLARED}PROGRAM P\nVAR it : {kind}; END_VAR\nEND_PROGRAM\n")
    plc = program(tmp_path / "p.st", dialect="edition-3")

    @given(plc.values("P.it"))
    def keeps(value: Any) -> None:
        plc["P.it"] = value
        assert plc["P.it"] == value

    keeps()


@pytest.mark.parametrize(
    ("options", "what"),
    [
        ({}, "a property is one condition"),
        ({"never": bool, "always": bool}, "a property is one condition"),
        ({"never": bool, "inputs": ["upp"]}, "Lift has no variable 'upp'"),
        ({"never": bool, "inputs": "up"}, "inputs cannot be 'up'"),
        ({"never": bool, "inputs": ["release"]}, "Lift.release is a TON"),
        ({"never": bool, "steps": 0}, "steps cannot be 0"),
        ({"never": bool, "every": -1}, "time cannot pass for -1"),
    ],
)
def test_what_is_no_property_is_refused(plc: ProgramBench, options: dict[str, Any], what: str) -> None:
    with pytest.raises(ArgumentError, match=what):
        plc.for_all(block=plc.block("Lift"), **options)


def test_without_the_library_the_extra_is_named(plc: ProgramBench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "hypothesis", None)
    with pytest.raises(UsageError) as caught:
        plc.for_all(block=plc.block("Lift"), never=lambda: False)
    assert "fieldrig[properties]" in caught.value.remedy
