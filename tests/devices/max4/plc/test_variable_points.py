"""Variables of a controller's program as points: read, written, and found again after a download."""

from pathlib import Path

import pytest
from plc_bench import PlcBench, task_of

from fieldrig.errors import ControlError

COUNTER = """
VAR_GLOBAL
  lStep : DINT := 5;
  asName : ARRAY[1..2] OF STRING(8) := ['film', 'infeed'];
  DiagCode : DINT := 4711;
END_VAR
VAR_GLOBAL CONSTANT
  c_lLimit : DINT := 1000;
END_VAR
PROGRAM PLC_PRG
VAR lCount : DINT := 100; fbDelay : TON; END_VAR
lCount := lCount + lStep;
fbDelay(IN := lCount > 200, PT := T#50ms);
END_PROGRAM
"""
TASK = task_of("PLC_PRG", 10)


@pytest.fixture
def bench(tmp_path: Path) -> PlcBench:
    """After ten cycles: the program has started at 92 ms."""
    return PlcBench(tmp_path, COUNTER + TASK).run(187)


def test_variables_of_the_project_and_of_its_programs_are_points(bench: PlcBench) -> None:
    assert (bench.get("lStep"), bench.get("PLC_PRG.lCount")) == (5, 150)
    assert (bench.get("asName[2]"), bench.get("PLC_PRG.fbDelay.Q")) == ("infeed", False)


def test_a_variable_is_written_and_the_next_cycle_computes_with_it(bench: PlcBench) -> None:
    bench.set("lStep", 1)
    bench.set("PLC_PRG.lCount", 0)
    bench.run(30)
    assert bench.get("PLC_PRG.lCount") == 3


def test_a_constant_is_read_only_and_a_value_has_to_fit(bench: PlcBench) -> None:
    with pytest.raises(ControlError, match="c_lLimit can only be read"):
        bench.set("c_lLimit", 5)
    with pytest.raises(ControlError, match="lStep cannot be 'many'"):
        bench.set("lStep", "many")
    assert (bench.get("c_lLimit"), bench.get("lStep")) == (1000, 5)


def test_a_parameter_keeps_its_name(bench: PlcBench) -> None:
    assert bench.value("DiagCode") == 4711
    assert bench.get("DiagCode") != 4711
