"""Instruction List: the examples of the manual with the results stated there, and what is refused."""

import pytest
from iec_check import messages
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect

LOOP = """Loop:
LD Counter
EQ 0
JMPC end

LD Var1
MUL 2
ST Var1

LD Counter
SUB 1
ST Counter
JMP Loop

end:
LD Var1
ST Erg"""

# Declarations, lines, and values at the end (digest 2.1, PD-L13 to PD-L35).
EXAMPLES = [
    (
        "lint : INT; test : BOOL; idword : DWORD;",
        "LD 17\nST lint (* comment *)\nGE 5\nJMPC next\nLD idword\nEQ 0\nST test\nnext:",
        {"lint": 17, "test": False},
    ),
    (  # PD-L14: ERG becomes BOOL2 in every case
        "BOOL1 : BOOL; BOOL2 : BOOL := TRUE; ERG : BOOL;",
        "LD TRUE\nANDN BOOL1\nJMPC marke\nLDN BOOL2\nST ERG\nmarke: LD BOOL2\nST ERG",
        {"ERG": True},
    ),
    ("Erg : INT;", "LD 2\nMUL 2\nADD 3\nST Erg", {"Erg": 7}),
    ("Erg : INT;", "LIMIT(\nMN := 1,\nIN := 9,\nMX := 4\n)\nST Erg", {"Erg": 4}),  # IEC 61131-3: a call in lines
    ("Erg : BOOL;", "EQ(\nIN1 := INT#2,\nIN2 := INT#3\n)\nSTN Erg", {"Erg": True}),  # an operator is a function as well
    ("Erg : INT;", "LD 1\nADD(IN1 := 2, IN2 := 3)\nST Erg", {"Erg": 5}),
    ("Erg : INT;", "begin: MAX(IN1 := 2, IN2 := (1 + 4) * 2)\nST Erg", {"Erg": 10}),
    ("Erg : INT;", "LD 2\nMUL ( 2\nADD 3\n) ST Erg", {"Erg": 10}),
    (  # PD-L19: Var1 * 2^Counter
        "Counter : INT := 5; Var1 : INT := 3; Erg : INT;",
        LOOP,
        {"Erg": 96, "Counter": 0},
    ),
    ("x : INT;", "LD 7\nADD 2,4,7\nST x", {"x": 20}),
    ("x : INT;", "LD 7\nMUL 2,4,7\nST x", {"x": 392}),
    ("x : INT;", "LD 7\nSUB 8\nST x", {"x": -1}),
    ("x : INT;", "LD 8\nDIV 2\nST x", {"x": 4}),
    ("x : INT;", "LD 9\nMOD 2\nST x", {"x": 1}),
    ("t : TIME;", "LD T#45s\nADD T#50s\nST t", {"t": 95_000}),
    ("a : ARRAY[0..4] OF INT; x : INT;", "LD a\nSIZEOF\nST x", {"x": 10}),
    ("x : BYTE;", "LD 2#1001_0011\nAND 2#1000_1010\nST x", {"x": 0b1000_0010}),
    ("x : BYTE;", "LD 2#1001_0011\nOR 2#1000_1010\nST x", {"x": 0b1001_1011}),
    ("x : BYTE;", "LD 2#1001_0011\nXOR 2#1000_1010\nST x", {"x": 0b0001_1001}),
    ("x : BYTE;", "LD 2#1001_0011\nNOT\nST x", {"x": 0b0110_1100}),
    ("x : BYTE; y : BYTE;", "LD 2#1001_0011\nST y\nLD y\nROL 3\nST x", {"x": 0b1001_1100}),
    ("x : BYTE; y : BYTE;", "LD 2#1001_0011\nST y\nLD y\nROR 3\nST x", {"x": 0b0111_0010}),
    ("x : BYTE;", "LD 1\nSHL 1\nST x", {"x": 2}),
    ("x : BYTE;", "LD 32\nSHR 2\nST x", {"x": 8}),
    ("x : INT;", "LD TRUE\nSEL 3,4\nST x", {"x": 4}),
    ("x : INT;", "LD FALSE\nSEL 3,4\nST x", {"x": 3}),
    ("x : INT;", "LD 90\nMAX 30\nMAX 40\nMAX 77\nST x", {"x": 90}),
    ("x : INT;", "LD 90\nMIN 30\nMIN 40\nMIN 77\nST x", {"x": 30}),
    ("x : INT;", "LD 90\nLIMIT 30,80\nST x", {"x": 80}),
    ("x : INT;", "LD 0\nMUX 30,40,50,60,70,80\nST x", {"x": 30}),
    ("x : BOOL := TRUE;", "LD 20\nGT 30\nST x", {"x": False}),
    ("x : BOOL;", "LD 20\nLT 30\nST x", {"x": True}),
    ("x : BOOL;", "LD 20\nLE 30\nST x", {"x": True}),
    ("x : BOOL;", "LD 60\nGE 40\nST x", {"x": True}),
    ("x : BOOL;", "LD 40\nEQ 40\nST x", {"x": True}),
    ("x : BOOL := TRUE;", "LD 40\nNE 40\nST x", {"x": False}),
    ("x : REAL;", "LD 2\nINT_TO_REAL\nMUL 3.5\nST x", {"x": 7.0}),
    ("x : BOOL := TRUE;", "LD 2.7\nREAL_TO_INT\nGE %MW8\nST x", {"x": True}),
    ("x : INT;", "LD 2.7\nTRUNC\nST x", {"x": 2}),
    ("x : REAL;", "LD 7\nEXPT 2\nST x", {"x": 49.0}),
    ("x : BOOL; v : INT;", "LD v\nADR\nNE 0\nST x", {"x": True}),
]


@pytest.mark.parametrize(("declarations", "lines", "expected"), EXAMPLES)
def test_an_example_of_the_manual_has_its_result(declarations: str, lines: str, expected: dict[str, object]) -> None:
    bench = IecBench(program(declarations, lines))
    bench.cycle()
    assert {name: bench[name] for name in expected} == expected


BLOCK = """
FUNCTION_BLOCK Inst
VAR_INPUT PAR1 : INT := 7; PAR2 : BOOL; END_VAR
VAR_OUTPUT sum : INT; END_VAR
IF PAR2 THEN sum := sum + PAR1 + 1; END_IF
END_FUNCTION_BLOCK
FUNCTION Twice : INT
VAR_INPUT a : INT; b : INT; END_VAR
LD a
MUL 2
ADD b
ST Twice
END_FUNCTION
"""

# What the manual says in words: modifiers, brackets in brackets, and the accumulator across stores, calls and labels.
MORE = [
    ("i : Inst; x : INT;", "CAL i(PAR1 := 0,\n  PAR2 := TRUE)\nLD i.sum\nST x", {"x": 1}),  # PD-L36
    ("i : Inst; x : INT;", "LD 5\nCAL i(PAR2 := TRUE, sum => x)\nADD x\nST x", {"x": 13}),
    ("i : Inst;", "LD FALSE\nCALC i(PAR2 := TRUE)\nCALCN i(PAR2 := TRUE, PAR1 := 1)", {"i.sum": 2}),
    ("i : Inst; x : INT;", "LD TRUE\nST i.PAR2\nCAL i\nLD i.sum\nST x", {"x": 8}),
    ("x : INT;", "LD 5\nTwice 3\nST x", {"x": 13}),
    ("x : INT;", "LD 0\nTwice(b := 1, a := 4)\nST x", {"x": 9}),
    ("x : INT; y : INT;", "LD x\nADD 1\nST x\nST y\nMUL 10\nST x", {"x": 10, "y": 1}),
    ("x : INT := 1;", "LD x\nADD x\nST x\nADD x\nST x", {"x": 4}),
    ("a : BOOL; b : BOOL := TRUE;", "LD TRUE\nS a\nR b", {"a": True, "b": False}),
    ("a : BOOL; b : BOOL := TRUE;", "LD FALSE\nS a\nR b", {"a": False, "b": True}),
    ("a : BOOL := TRUE;", "LD a\nR a\nST a", {"a": True}),
    ("x : INT;", "LD 1\nADD ( 2\nMUL ( 3\nADD 4\n)\nSUB 1\n)\nST x", {"x": 1 + 2 * 7 - 1}),
    ("x : BOOL; a : BOOL := TRUE;", "LD a\nANDN ( a\nXOR a\n)\nST x", {"x": True}),
    ("x : BOOL; a : BOOL; b : BOOL := TRUE;", "LD a\nOR (\nLD b\nAND b\n)\nST x", {"x": True}),
    ("x : INT; y : INT;", "LD 3\nADD ( 4\nST y\n)\nST x", {"x": 7, "y": 4}),
    ("x : INT := 9;", "LD TRUE\nRETC\nLD 1\nST x", {"x": 9}),
    ("x : INT := 9;", "LD TRUE\nRETCN\nLD 1\nST x", {"x": 1}),
    ("x : INT := 9;", "RET\nLD 1\nST x", {"x": 9}),
    (
        "x : INT; n : INT;",
        "LD 5\nJMP there\nLD 6\nthere: ST x\nLD x\nEQ 5\nJMPCN end\nLD 1\nST n\nend:",
        {"x": 5, "n": 1},
    ),
    (  # the accumulator reaches a label on two ways
        "x : INT; a : BOOL := TRUE; b : BOOL;",
        "LD a\nJMPC store\nLD FALSE\nstore:\nST b\nS b\nLD 3\nST x",
        {"b": True, "x": 3},
    ),
    ("x : DINT;", "LD 0\n" + "ADD 1\n" * 200 + "ST x", {"x": 200}),
]


@pytest.mark.parametrize(("declarations", "lines", "expected"), MORE)
def test_lines_of_il_do_what_the_manual_says(declarations: str, lines: str, expected: dict[str, object]) -> None:
    bench = IecBench(BLOCK + program(declarations, lines))
    bench.cycle()
    assert {name: bench[name] for name in expected} == expected


REFUSED = [
    ("ST x", ["1:1 ST has no value to work with; LD in a line before it"]),
    ("LD 8\nDIV2\nST x", ["2:1 DIV2 is neither an operator of IL nor a function; LD, ST or another operator"]),
    ("LD x\nST 5", ["2:4 5 is a value; a variable"]),
    ("LD x\nJMP there", ["2:5 there is no label there; a line there: in the same body"]),
    ("a: LD x\na: ST x", ["2:1 the label a exists already in line 2; another name"]),
    ("LD x\nS x", ["1:4 x is an INT; BOOL"]),
    ("LD b\nS x", ["2:3 x is an INT; a BOOL behind S"]),
    ("LD 1,2\nST x", ["1:1 LD has 2 operands; one operand"]),
    ("LD x\nST x,y", ["2:1 ST has 2 operands; one variable"]),
    ("LD x\nADD\nST x", ["2:1 ADD has no operand; an operand"]),
    ("LD b\nNOT b\nST b", ["2:1 NOT has an operand; NOT alone"]),
    ("CAL\nLD x", ["1:1 CAL has no operand; an instance, a program or an action"]),
    ("CAL x", ["1:5 x is an INT and cannot be called; an instance, program or function"]),
    (
        "LD x\nADD ( 3\na: SUB 1\n)\nST x",
        ["3:1 a label is in brackets; a label in front of the operator with the bracket"],
    ),
]


@pytest.mark.parametrize(("lines", "expected"), REFUSED)
def test_what_is_wrong_in_il_is_refused(lines: str, expected: list[str]) -> None:
    text = f"PROGRAM PLC_PRG VAR x : INT; y : INT; b : BOOL; END_VAR\n{lines}\nEND_PROGRAM"
    moved = [f"{int(line) + 1}:{rest}" for line, _, rest in (message.partition(":") for message in expected)]
    assert messages(text) == moved


@pytest.mark.parametrize("dialect", [EPAS_4, CODESYS], ids=lambda dialect: dialect.name)
def test_the_accumulator_has_32_bits(dialect: Dialect) -> None:
    """It keeps them behind an ST, whose variable gets the lowest 16: 900000000 is 16#35A4E900, and 16#E900 is -5888."""
    lines = "LD w\nADD 1\nST d\nLD i\nMUL i\nST n\nST s\nST m\nLD i\nADD i\nGT 40000\nST b"
    declared = "w : WORD := 65535; d : DWORD; i : INT := 30000; n, m : DINT; s : INT; b : BOOL;"
    bench = IecBench(program(declared, lines), dialect, name="main.il")
    bench.cycle()
    assert [bench[name] for name in "dnsmb"] == [65536, 900_000_000, -5888, 900_000_000, True]


# IEC 61131-3, tables of IL: inputs of the standard function blocks are operators

INPUTS = """LD limit
PV counter
LD clear
R counter
LDN pulse
ST pulse
CU counter
ST pulse
LD counter.Q
S full
LD TRUE
S1 latch"""


def test_inputs_of_function_blocks_are_operators() -> None:
    declarations = "counter : CTU; limit : INT := 2; clear, pulse, full : BOOL; latch : SR;"
    bench = IecBench(program(declarations, INPUTS), EDITION_3)
    found = []
    for _ in range(4):
        bench.cycle()
        found.append((bench["counter.CV"], bench["full"], bench["latch.Q1"]))
    assert found == [(1, False, True), (1, False, True), (2, True, True), (2, True, True)]


@pytest.mark.parametrize("dialect", [EPAS_4, CODESYS])
def test_inputs_are_operators_in_edition_3_alone(dialect: Dialect) -> None:
    (message,) = messages(program("late : TON;", "LD TRUE\nIN late"), dialect=dialect)
    assert "IN is neither an operator of IL nor a function" in message


@pytest.mark.parametrize(("lines", "expected"), [("LD 5\nIN late", "BOOL"), ("LD TRUE\nCU late", "CU is neither")])
def test_an_input_as_operator_has_the_rules_of_a_call(lines: str, expected: str) -> None:
    (message,) = messages(program("late : TON;", lines), dialect=EDITION_3)
    assert expected in message
