"""The classes of variables in a program that runs (manual 971-996)."""

import pytest
from iec_program import IecBench

PROGRAM = """
VAR_GLOBAL gTotal : DINT := 100; END_VAR
FUNCTION_BLOCK Counter
VAR_INPUT step : INT := 5; END_VAR
VAR_OUTPUT count : INT; END_VAR
VAR_IN_OUT shared : INT; END_VAR
VAR_EXTERNAL gTotal : DINT; END_VAR
VAR CONSTANT LIMIT : INT := 12; END_VAR
VAR calls : INT; END_VAR
calls := calls + 1;
IF count + step <= LIMIT THEN count := count + step; END_IF
shared := shared + count;
gTotal := gTotal + step;
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR first, second : Counter; own : INT := 1000; other : INT := -1; lamp AT %QB4 : BYTE; seen : BYTE; END_VAR
first(shared := own);
second(step := 2, shared := other);
lamp := 16#A5;
seen := %QB4;
END_PROGRAM
"""


@pytest.mark.manual("PD-351")
def test_each_class_of_variables_keeps_and_shares_what_it_has_to() -> None:
    bench = IecBench(PROGRAM)
    bench.cycle(3)
    assert [bench[name] for name in ("first.count", "second.count")] == [10, 6]  # 12 limits the first one
    assert [bench[name] for name in ("first.calls", "second.calls")] == [3, 3]
    assert (bench["own"], bench["other"]) == (1000 + 5 + 10 + 10, -1 + 2 + 4 + 6)  # VAR_IN_OUT is the caller's variable
    assert bench["gTotal"] == 100 + 3 * (5 + 2)  # VAR_EXTERNAL is the global one
    assert [bench[name] for name in ("first.step", "second.step")] == [5, 2]
    assert (bench["lamp"], bench["seen"]) == (0xA5, 0xA5)
