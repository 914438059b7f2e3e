"""VAR_GENERIC CONSTANT and VAR_OUTPUT CONSTANT (the public descriptions of CODESYS V3 and TwinCAT 3)."""

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit

BLOCKS = """
VAR_GLOBAL CONSTANT MOST : UDINT := 4; END_VAR
FUNCTION_BLOCK Stack
VAR_GENERIC CONSTANT
    size : UDINT := 2;
    factor : DINT := 1;
END_VAR
VAR_OUTPUT n : UDINT; END_VAR
VAR_OUTPUT CONSTANT limit : INT := 77; END_VAR
VAR items : ARRAY[1..size] OF DINT; END_VAR
METHOD Push : BOOL
VAR_INPUT x : DINT; END_VAR
IF n < size THEN n := n + 1; items[n] := x * factor; Push := TRUE; END_IF
END_METHOD
METHOD Room : UDINT
Room := SIZEOF(items);
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Pair
VAR_GENERIC CONSTANT k : UDINT; END_VAR
VAR inner : Stack<2 * k, 10>; END_VAR
METHOD Room : UDINT
Room := inner.Room();
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Big EXTENDS Stack<100>
END_FUNCTION_BLOCK
"""


@pytest.mark.parametrize(
    ("declared", "room"),
    [
        ("x : Stack<3>;", 12),
        ("x : Stack;", 8),
        ("x : Stack<own>;", 12),
        ("x : Stack<MOST>;", 16),
        ("x : Stack<own - 2, 5>;", 4),
        ("x : Pair<own>;", 24),
        ("x : Big;", 400),
        ("x : Stack<16#10>;", 64),
    ],
)
def test_each_use_has_its_own_constants(declared: str, room: int) -> None:
    text = BLOCKS + program(f"{declared} room : UDINT; END_VAR VAR CONSTANT own : UDINT := 3;", "room := x.Room();")
    bench = IecBench(text, CODESYS)
    bench.cycle()
    assert bench["room"] == room


def test_the_same_constants_make_the_same_type() -> None:
    declared = "a : Stack<3, 5>; b : Stack<own + 1, 5>; p : POINTER TO Stack<(2 + 1), 5>; r : DINT; n : INT;"
    constants = "END_VAR VAR CONSTANT own : UDINT := 2;"
    body = "b.Push(7); a := b; p := ADR(a); p^.Push(8); r := p^.items[1] + p^.items[2]; n := p^.limit;"
    bench = IecBench(BLOCKS + program(declared + constants, body), CODESYS)
    bench.cycle()
    assert (bench["r"], bench["n"]) == (75, 77)


def test_arrays_and_blocks_with_arguments_have_them_too() -> None:
    block = (
        "FUNCTION_BLOCK Init VAR_GENERIC CONSTANT k : INT; END_VAR VAR s : INT; END_VAR\n"
        "METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; x : INT; END_VAR s := x * k; END_METHOD\n"
        "METHOD Value : INT Value := s; END_METHOD END_FUNCTION_BLOCK\n"
    )
    bench = IecBench(
        BLOCKS
        + block
        + program(
            "i : Init<3>(x := 7); a : ARRAY[0..1] OF Stack<5>; r, q : DINT;", "r := i.Value(); q := a[1].Room();"
        ),
        CODESYS,
    )
    bench.cycle()
    assert (bench["r"], bench["q"]) == (21, 20)


def test_the_printed_program_is_the_same() -> None:
    text = BLOCKS + program("x : Stack<3, 5>;", "x.Push(1);")
    printed = print_unit(parse(text, "main.st", CODESYS)[0])
    assert "Stack<3, 5>" in printed
    assert "EXTENDS Stack<100>" in printed
    assert print_unit(parse(printed, "main.st", CODESYS)[0]) == printed


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (program("x : Stack<1, 2, 3>;", ""), "Stack has 2 generic constants; expected at most 2 between < and >"),
        (program("x : Plain<1>;", ""), "Plain has no generic constants; expected Plain without < and >"),
        (program("x : Stack<1;", ""), "> for the <"),
        ("FUNCTION F : INT VAR_GENERIC CONSTANT k : INT; END_VAR F := 1; END_FUNCTION", "VAR_GENERIC in a FUNCTION"),
        (
            "FUNCTION_BLOCK Deep VAR_GENERIC CONSTANT k : INT; END_VAR VAR p : POINTER TO Deep<k + 1>; END_VAR\n"
            "END_FUNCTION_BLOCK\n" + program("x : Deep<1>;", ""),
            "needs another copy of a generic block with each copy",
        ),
    ],
)
def test_mistakes_are_named(text: str, said: str) -> None:
    plain = "FUNCTION_BLOCK Plain VAR a : INT; END_VAR END_FUNCTION_BLOCK\n"
    assert said in "\n".join(refused(BLOCKS + plain + text, CODESYS))


def test_another_dialect_has_none() -> None:
    assert refused(program("x : Stack<1>;", ""), EDITION_3)
