"""In Python, an instance under test may be given to an interface, a pointer, a reference or a VAR_IN_OUT."""

from pathlib import Path
from typing import Any

import pytest

from fieldrig import ArgumentError, ProgramBench, program

TEXT = """
INTERFACE ICounter
METHOD Count : INT END_METHOD
END_INTERFACE
INTERFACE IBoth EXTENDS ICounter
END_INTERFACE
FUNCTION_BLOCK Ones IMPLEMENTS IBoth
VAR_OUTPUT sum : INT; END_VAR
METHOD Count : INT
sum := sum + 1; Count := sum;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Tens EXTENDS Ones
METHOD Count : INT
sum := sum + 10; Count := sum;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Plain
VAR calls : INT; END_VAR
calls := calls + 1;
END_FUNCTION_BLOCK
FUNCTION_BLOCK User
VAR_INPUT
    counter : ICounter; ones : POINTER TO Ones; same : REFERENCE TO Ones; plain : POINTER TO Plain;
    all : ARRAY[1..2] OF ICounter;
END_VAR
VAR_OUTPUT counted, seen : INT; END_VAR
VAR i : INT; END_VAR
IF counter <> 0 THEN counted := counter.Count(); END_IF
IF ones <> 0 THEN seen := ones^.sum; END_IF
IF plain <> 0 THEN plain^(); END_IF
IF __ISVALIDREF(same) THEN seen := same.Count(); END_IF
FOR i := 1 TO 2 DO
    IF all[i] <> 0 THEN counted := counted + all[i].Count(); END_IF
END_FOR
END_FUNCTION_BLOCK
FUNCTION Twice : INT
VAR_INPUT counter : ICounter; END_VAR
Twice := 2 * counter.Count();
END_FUNCTION
"""


@pytest.fixture
def plc(tmp_path: Path) -> ProgramBench:
    (tmp_path / "counters.st").write_text(TEXT, encoding="utf-8")
    return program(tmp_path / "counters.st", dialect="codesys")


def test_the_method_of_the_given_instance_is_called(plc: ProgramBench) -> None:
    user, ones, tens = plc.block("User"), plc.block("Ones"), plc.block("Tens")
    assert user(counter=tens).counted == 10
    assert user(counter=ones).counted == 1
    assert user(counter=None).counted == 1
    assert (ones.sum, tens.sum) == (1, 10)
    assert plc.function("Twice")(tens) == 40


def test_pointers_and_references_see_the_given_instance(plc: ProgramBench) -> None:
    user, tens, plain = plc.block("User"), plc.block("Tens"), plc.block("Plain")
    tens.sum = 7
    assert user(ones=tens).seen == 7
    assert user(same=tens).seen == 17
    assert user(plain=plain) is user
    assert plain.calls == 1


def test_an_array_of_interfaces_takes_a_list_of_instances(plc: ProgramBench) -> None:
    user, ones, tens = plc.block("User"), plc.block("Ones"), plc.block("Tens")
    assert user(all=[tens, ones]).counted == 11
    assert user(all=[None, tens]).counted == 31


@pytest.mark.parametrize(
    ("name", "expected"),
    [("counter", "ICounter, not one of Plain"), ("ones", "Ones, not one of Plain"), ("same", "Ones, not one of Plain")],
)
def test_an_instance_of_another_block_is_refused(plc: ProgramBench, name: str, expected: str) -> None:
    user, plain = plc.block("User"), plc.block("Plain")
    with pytest.raises(ArgumentError, match=expected):
        user(**{name: plain})


def test_what_is_no_instance_of_this_program_is_refused(plc: ProgramBench, tmp_path: Path) -> None:
    user, ones = plc.block("User"), program(tmp_path / "counters.st", dialect="codesys").block("Ones")
    values: list[Any] = [ones, "ones"]
    for value, expected in zip(values, ("of this program, not of another", "None, or an instance"), strict=True):
        with pytest.raises(ArgumentError, match=expected):
            user(counter=value)


PASSED = """
FUNCTION_BLOCK Valve
VAR_INPUT open : BOOL; END_VAR
VAR_OUTPUT count : INT; END_VAR
IF open THEN count := count + 1; END_IF;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Opener
VAR_IN_OUT valve : Valve; END_VAR
valve(open := TRUE);
END_FUNCTION_BLOCK
FUNCTION OpenedBy : INT
VAR_INPUT times : INT; END_VAR
VAR_IN_OUT valve : Valve; END_VAR
VAR i : INT; END_VAR
FOR i := 1 TO times DO valve(open := TRUE); END_FOR;
OpenedBy := valve.count;
END_FUNCTION
"""


@pytest.fixture(params=["epas-4", "edition-3", "codesys"])
def valves(tmp_path: Path, request: pytest.FixtureRequest) -> ProgramBench:
    (tmp_path / "valves.st").write_text(PASSED, encoding="utf-8")
    return program(tmp_path / "valves.st", dialect=request.param)


def test_an_instance_is_passed_to_a_var_in_out(valves: ProgramBench) -> None:
    opener, valve, other = valves.block("Opener"), valves.block("Valve"), valves.block("Valve")
    opener(valve=valve)
    opener()  # it keeps what it was given, as inputs do
    opener(valve=other)
    assert (valve.count, other.count, opener.valve.count) == (2, 1, 1)


def test_without_an_instance_a_var_in_out_has_one_of_its_own(valves: ProgramBench) -> None:
    opener, valve = valves.block("Opener"), valves.block("Valve")
    opener()
    assert opener.valve.count == 1
    opener(valve=valve)
    opener(valve={"count": 7})
    assert (opener.valve.count, valve.count) == (8, 1)


def test_an_instance_is_passed_to_a_function(valves: ProgramBench) -> None:
    opened_by, valve = valves.function("OpenedBy"), valves.block("Valve")
    assert (opened_by(3, valve), opened_by(times=1, valve=valve), valve.count) == (3, 4, 4)
    assert (opened_by(1), opened_by(1, {"count": 5}), valve.count) == (1, 6, 4)


def test_what_is_no_instance_of_the_block_is_refused_for_a_var_in_out(valves: ProgramBench) -> None:
    opener = valves.block("Opener")
    with pytest.raises(
        ArgumentError, match=r"(?s)Opener\.valve cannot be .*expected an instance of Valve, not one of Opener"
    ):
        opener(valve=valves.block("Opener"))
    with pytest.raises(ArgumentError, match=r"expected an instance of Valve under test, or a dict with values of it"):
        opener(valve=3)
