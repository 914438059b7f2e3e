"""The values that variables keep in an online change that gives them another place."""

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec.carrying import Carrier

DECLARED = """TYPE Pair : STRUCT a : INT; b : REAL := 0.5; END_STRUCT END_TYPE
TYPE Level : (low, high); END_TYPE
FUNCTION_BLOCK Belt
VAR_IN_OUT other : INT; END_VAR
VAR first, second : DINT; pairs : ARRAY[1..3] OF Pair; text : STRING(5) := 'ab'; level : Level; END_VAR
second := second + 1; other := other + 1; pairs[3].a := 33; text := 'cd'; level := high;
END_FUNCTION_BLOCK
"""
MAIN = program("n : INT; belt : Belt; belts : ARRAY[0..1] OF Belt; grid : ARRAY[0..1, 0..2] OF INT;",
               "belt(other := n); belts[1](other := n); grid[1, 2] := 12; grid[0, 1] := 1; n := n + 10;")  # fmt: skip


def after(changes: dict[str, str], cycles: int = 2) -> IecBench:
    """Run the program, and change it online."""
    bench = IecBench(DECLARED + MAIN)
    bench.cycle(cycles)
    text = DECLARED + MAIN
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    bench.runtime.change(bench.compile(text, previous=bench.compiled))
    return bench


@pytest.mark.manual("PD-225")
def test_parts_of_instances_structures_and_arrays_keep_their_values_on_their_own() -> None:
    bench = after({
        "VAR first, second": "VAR more : LREAL := 2.5; first, second",
        "STRUCT a : INT;": "STRUCT new : BYTE := 7; a : INT;",
        "grid : ARRAY[0..1, 0..2]": "grid : ARRAY[1..2, 1..4]",
        "grid[0, 1] := 1;": "",
        "belts : ARRAY[0..1]": "belts : ARRAY[-1..1]",
    })  # fmt: skip
    kept = {
        "belt.second": 2, "belt.pairs[3].a": 33, "belt.pairs[3].b": 0.5, "belt.text": "cd", "belt.level": 1,
        "belts[1].second": 2, "belts[0].second": 0, "belts[-1].second": 0, "grid[1,2]": 12, "n": 24,
    }  # fmt: skip
    new = {"belt.more": 2.5, "belt.pairs[3].new": 7, "grid[1,1]": 0, "grid[2,4]": 0, "belts[-1].text": "ab"}
    assert {path: bench[path] for path in kept | new} == kept | new
    bench.cycle()
    assert (bench["belt.second"], bench["n"]) == (3, 36)


def test_a_variable_of_another_type_gets_its_start_value_and_those_around_it_keep_theirs() -> None:
    bench = after({
        "second : DINT;": "second : DINT; between : INT := 3;",
        "text : STRING(5) := 'ab'": "text : STRING(6) := 'ef'",
        "level : Level;": "level : INT := 9;",
        "level := high;": "",
    })  # fmt: skip
    assert [bench[f"belt.{name}"] for name in ("second", "between", "pairs[3].a", "text", "level")] == [
        2, 3, 33, "ef", 9,
    ]  # fmt: skip


def test_a_reference_is_given_again_by_the_next_call() -> None:
    bench = after({"VAR first,": "VAR more, first,"})
    with pytest.raises(ValueError, match="refers to nothing yet"):
        bench["belt.other"]
    bench.cycle()
    assert bench["belt.other"] == 36


def test_cells_that_follow_one_another_are_kept_as_one_run() -> None:
    text = DECLARED.replace("VAR_IN_OUT other : INT; END_VAR", "").replace("other := other + 1;", "")
    main = program("belts : ARRAY[0..9] OF Belt;", "belts[1]();")
    first, second = (IecBench(text + main).compiled.program.globals["plc_prg"].type for _ in range(2))
    assert Carrier().runs(first, second) == [(0, 0, first.size)]
