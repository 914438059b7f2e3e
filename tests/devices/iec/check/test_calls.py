"""Calls of functions, function blocks, programs and actions, and what is passed to them."""

import pytest
from iec_check import checked, messages, program

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    Assign,
    CallAction,
    CallBlock,
    CallFunction,
    Cell,
    Component,
    Constant,
    Evaluate,
    Load,
    Pou,
)
from fieldrig_devices.iec.types import BlockType

F = "FUNCTION F : INT VAR_INPUT a : INT; b : INT := 3; END_VAR F := a + b; END_FUNCTION"


def body(*texts: str) -> list[object]:
    found, mistakes = checked(*texts)
    assert not [mistake for mistake in mistakes if not mistake.is_note], mistakes
    return list(found.pous["plc_prg"].body)


def constants(call: object) -> dict[str, object]:
    assert isinstance(call, CallFunction)
    return {variable.name: value.value for variable, value in call.inputs if isinstance(value, Constant)}


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ("F(1, 2)", {"a": 1, "b": 2}),
        ("F(b := 2, a := 1)", {"a": 1, "b": 2}),
        ("F(1)", {"a": 1, "b": 3}),
        ("F(a := 1)", {"a": 1, "b": 3}),
    ],
)
def test_a_function_takes_arguments_by_position_or_by_name(call: str, expected: dict[str, int]) -> None:
    (statement,) = body(F, program("x : INT;", f"x := {call};"))
    assert isinstance(statement, Assign)
    assert constants(statement.value) == expected


def test_a_function_may_be_called_for_its_effects() -> None:
    (statement,) = body(F, program("x : INT;", "F(1);"))
    assert isinstance(statement, Evaluate)


def test_a_function_call_is_an_operand() -> None:
    function = "FUNCTION Fct : INT VAR_INPUT i : INT; END_VAR Fct := i; END_FUNCTION"
    assert messages(function, program("Result : INT;", "Result := Fct(7) + 3;")) == []  # PD-L49


BLOCK = """FUNCTION_BLOCK Counter
VAR_INPUT iMode : INT; END_VAR VAR_OUTPUT iCounter : INT; END_VAR VAR_IN_OUT total : INT; END_VAR
IF iMode = 0 THEN iCounter := 0; ELSIF iMode = 1 THEN iCounter := iCounter + 1; END_IF
total := total + 1;
ACTION Clear : iCounter := 0; END_ACTION
END_FUNCTION_BLOCK"""


@pytest.mark.manual("PD-366")
@pytest.mark.manual("PD-355")
def test_an_instance_is_called_with_named_inputs_and_its_outputs_are_read_afterwards() -> None:
    call, read = body(
        BLOCK, program("c : Counter; n : INT; act : INT;", "c(iMode := 1, total := n); act := c.iCounter;")
    )
    assert isinstance(call, CallBlock)
    assert [(variable.name, value) for variable, value in call.inputs] == [("iMode", Constant(1, Elementary.INT))]
    assert [variable.name for variable, _ in call.references] == ["total"]
    assert isinstance(read, Assign)
    assert isinstance(read.value, Load)
    pin = read.value.place
    assert isinstance(pin, Component)
    assert pin.variable is call.pou.variables["icounter"]


@pytest.mark.manual("PD-366")
def test_outputs_may_be_assigned_in_the_call() -> None:
    (call,) = body(BLOCK, program("c : Counter; n : INT; act : DINT;", "c(iMode := 1, total := n, iCounter => act);"))
    assert isinstance(call, CallBlock)
    ((target, value),) = call.outputs
    assert target.type is value.type is Elementary.DINT


@pytest.mark.manual("PD-366")
def test_arguments_of_an_instance_need_names() -> None:
    assert messages(program("t : TON;", "t(TRUE, T#1s);")) == [
        "3:3 TON is called with an argument without a name; IN := TRUE",
        "3:9 TON is called with an argument without a name; IN := T#1s",
    ]


def test_a_bare_number_is_no_time() -> None:
    assert messages(program("t : TON;", "t(IN := %IX5, PT := 300);")) == [
        "3:21 the number 300 is no TIME; TIME"
    ]  # PD-L21, X29


def test_instances_in_arrays_and_behind_pointers_can_be_called() -> None:
    text = program(
        "t : ARRAY[1..3] OF TON; p : POINTER TO TON; i : INT; b : BOOL;",
        "t[i](IN := TRUE); p := ADR(t[2]); p^(IN := FALSE); b := t[2].Q;",
    )
    assert messages(text) == []


def test_actions_are_called_alone_or_for_an_instance() -> None:
    text = """PROGRAM PLC_PRG VAR c : Counter; x : INT; END_VAR
Init; Init(); c.Clear; c.Clear(iMode := 3);
ACTION Init : x := 0; END_ACTION
END_PROGRAM"""
    first, second, third, given, fourth = body(BLOCK, text)
    for call, instance in ((first, False), (second, False), (third, True), (fourth, True)):
        assert isinstance(call, CallAction)
        assert (call.instance is not None) is instance
    assert isinstance(given, Assign)


def test_a_program_calls_another_program() -> None:
    text = (
        "PROGRAM P2 VAR_INPUT k : INT; END_VAR VAR_OUTPUT z : INT; END_VAR VAR own : INT; END_VAR z := k; END_PROGRAM"
    )
    call, _, _ = body(text, program("x : INT;", "P2(k := 3); x := P2.z; x := P2.own;"))
    assert isinstance(call, CallBlock)
    assert isinstance(call.instance, Cell)
    assert isinstance(call.instance.type, BlockType)


# ---- VAR_IN_OUT


@pytest.mark.manual("PD-352")
@pytest.mark.parametrize(
    ("argument", "expected"),
    [
        ("w", "w is a located BOOL and has no address for the VAR_IN_OUT b; a variable without AT (PD-352)"),
        ("%QX3.0", "%QX3.0 is a located BOOL and has no address for the VAR_IN_OUT b; a variable without AT (PD-352)"),
        ("x.3", "x.3 is a bit and has no address for the VAR_IN_OUT b; a variable without AT (PD-352)"),
        (
            "Axis_10.Enable",
            "Axis_10.Enable is a parameter and has no address for the VAR_IN_OUT b; a variable without AT (PD-352)",
        ),
        ("TRUE", "TRUE is passed to the VAR_IN_OUT b; a variable"),
        ("x", "x is an INT; a variable of type BOOL for the VAR_IN_OUT b"),
    ],
)
def test_what_cannot_be_passed_by_its_address(argument: str, expected: str) -> None:
    block = "FUNCTION_BLOCK B VAR_IN_OUT b : BOOL; END_VAR b := TRUE; END_FUNCTION_BLOCK"
    found = messages(
        block, program("i : B; w AT %MX5.0 : BOOL; x : INT; ok : BOOL;", f"i(b := {argument}); i(b := ok);")
    )
    assert [message.partition(" ")[2] for message in found] == [expected]


@pytest.mark.manual("PD-352")
def test_a_function_block_may_be_called_through_a_reference() -> None:
    block = "FUNCTION_BLOCK B VAR_IN_OUT t : TON; END_VAR t(IN := TRUE, PT := T#1s); END_FUNCTION_BLOCK"
    assert messages(block, program("b : B; t : TON;", "b(t := t);")) == []


@pytest.mark.manual("PD-353")
def test_inputs_are_copies_so_an_instance_cannot_be_one() -> None:
    block = "FUNCTION_BLOCK B VAR_INPUT a : ARRAY[1..9] OF INT; END_VAR ; END_FUNCTION_BLOCK"
    assert messages(block, program("b : B; a : ARRAY[1..9] OF INT;", "b(a := a);")) == []
    assert messages("FUNCTION_BLOCK C VAR_INPUT t : TON; END_VAR ; END_FUNCTION_BLOCK") == [
        "1:28 the instance t of TON in VAR_INPUT; another section"
    ]


# ---- configuration objects


@pytest.mark.manual("PD-023")
@pytest.mark.manual("PD-024")
@pytest.mark.manual("PD-025")
@pytest.mark.manual("PD-353")
def test_an_object_of_the_configuration_is_passed_by_reference() -> None:
    block = """FUNCTION_BLOCK Procedure VAR_INPUT r_MC_4 : MC_4; END_VAR
ControllerEnableSet(r_MC_4.logAdr);
END_FUNCTION_BLOCK"""
    (call,) = body(block, program("p : Procedure;", "p(r_MC_4 := Axis_10);"))  # PD-L50
    assert isinstance(call, CallBlock)
    ((_, value),) = call.inputs
    assert isinstance(value, Constant)
    assert value.value == 0x5000
    assert body(program("x : DINT;", "x := _Axis_10; x := Axis_10.logAdr; x := PacDriveM.Timer1;"))


@pytest.mark.manual("PD-022")
@pytest.mark.manual("PD-024")
def test_the_logical_address_of_an_object_is_a_constant() -> None:
    found = body(program("x : DINT;", "x := _Axis_10; x := Axis_10.logAdr;"))
    assert [statement.value for statement in found if isinstance(statement, Assign)] == [
        Constant(0x5000, Elementary.DINT)
    ] * 2


@pytest.mark.manual("PD-023")
@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("p(r_MC_4 := PacDriveM);", "3:13 PacDriveM is a PacDriveM; MC_4"),
        ("p(r_MC_4 := 5);", "3:13 the number 5 is no MC_4; MC_4"),
        ("x := Axis_10;", "3:6 Axis_10 is an MC_4; DINT"),
        (
            "Axis_10.AxisState := 3;",
            "3:8 the parameter Axis_10.AxisState can only be read; a variable that may be written here",
        ),
        ("x := Axis_10.Foo;", "3:13 MC_4 has no parameter Foo; a parameter of the object"),
        ("Axis_10 := 3;", "3:1 Axis_10 is a configuration object; a variable that may be written here"),
    ],
)
def test_objects_are_used_as_their_kind_allows_it(statement: str, expected: str) -> None:
    block = "FUNCTION_BLOCK Procedure VAR_INPUT r_MC_4 : MC_4; END_VAR r_MC_4.Enable := TRUE; END_FUNCTION_BLOCK"
    assert messages(block, program("p : Procedure; x : DINT;", statement)) == [expected]


def test_only_libraries_have_native_bodies() -> None:
    text = "FUNCTION Mine : INT\n{native}\nEND_FUNCTION"
    assert [message.partition(" ")[2] for message in messages(text)] == [
        "the controller does not implement Mine; a body"
    ]


def test_actions_have_the_variables_of_their_pou() -> None:
    found, _ = checked(BLOCK)
    counter = found.pous["counter"]
    action = counter.actions["clear"]
    assert isinstance(action, Pou)
    assert action.variables is counter.variables
    assert action.owner is counter
