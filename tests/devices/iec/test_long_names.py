"""Names of more than the 32 characters that count in EPAS-4 (PD-350) run, and are found as they are written."""

import pytest
from iec_program import IecBench

from fieldrig_devices.iec.debugged_scopes import Scope
from fieldrig_devices.iec.dialect import EDITION_3, EPAS_4, Dialect

TAIL = "WithANameThatIsLongerThanThirtyTwoCharacters"
PROGRAM = f"""TYPE Pair{TAIL} : STRUCT Part{TAIL} : INT; END_STRUCT END_TYPE
FUNCTION_BLOCK Block{TAIL}
VAR_INPUT Input{TAIL} : INT; END_VAR
VAR Sum{TAIL} : INT; Pairs{TAIL} : ARRAY[1..2] OF Pair{TAIL}; END_VAR
Sum{TAIL} := Sum{TAIL} + Input{TAIL};
Pairs{TAIL}[2].Part{TAIL} := 7;
ACTION Act{TAIL}: Sum{TAIL} := Sum{TAIL} + 100; END_ACTION
END_FUNCTION_BLOCK
VAR_GLOBAL RETAIN Total{TAIL} : DINT; END_VAR
PROGRAM Main{TAIL}
VAR Instance{TAIL} : Block{TAIL}; END_VAR
Instance{TAIL}(Input{TAIL} := 2);
Instance{TAIL}.Act{TAIL}();
Total{TAIL} := Total{TAIL} + 1;
END_PROGRAM
"""
INSTANCE = f"Main{TAIL}.Instance{TAIL}"


@pytest.mark.manual("PD-350")
@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3])
def test_a_program_with_long_names_runs_and_its_variables_are_found(dialect: Dialect) -> None:
    bench = IecBench(PROGRAM, dialect, main=f"Main{TAIL}")
    runtime = bench.runtime
    runtime.force(runtime.find(f"{INSTANCE}.Sum{TAIL}"), 40)
    bench.cycle(2)
    paths = (f"Total{TAIL}", f"{INSTANCE}.Sum{TAIL}", f"{INSTANCE}.Pairs{TAIL}[2].Part{TAIL}")
    assert [runtime.read(runtime.find(path)) for path in paths] == [2, 40, 7]
    for symbol in runtime.symbols.values():
        assert runtime.symbols.find(symbol.path) == symbol


@pytest.mark.parametrize(("dialect", "is_found"), [(EPAS_4, True), (EDITION_3, False)])
def test_another_end_of_a_long_name_is_the_same_name_in_epas_4_only(dialect: Dialect, is_found: bool) -> None:
    bench = IecBench(PROGRAM, dialect, main=f"Main{TAIL}")
    assert (bench.runtime.symbols.find(f"Total{TAIL}AndMore") is not None) is is_found


def test_a_breakpoint_shows_the_variables_of_an_action_with_a_long_name() -> None:
    bench = IecBench(PROGRAM, main=f"Main{TAIL}")
    line = 1 + PROGRAM[: PROGRAM.index("ACTION")].count("\n")
    assert bench.runtime.break_at({"main.st": {line}}) == {"main.st": {line}}
    bench.thread.start()
    bench.thread.run(10**9)
    scope = Scope.of(bench.runtime, bench.thread, 1, 0)
    assert scope is not None
    assert f"{INSTANCE}.Sum{TAIL}" in {symbol.path for symbol in scope.symbols()}
    found = scope.find(f"Sum{TAIL}")
    assert found is not None
    assert bench.runtime.read(found) == 2
