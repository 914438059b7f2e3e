"""Random expressions of all integer types, REAL and LREAL, against exact arithmetic that is written here.

Python's integers are cut to the type after every operation, and single precision is a round trip through `struct`.
"""

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass, replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.types import Value

BITS = {"SINT": 8, "INT": 16, "DINT": 32, "LINT": 64, "USINT": 8, "UINT": 16, "UDINT": 32, "ULINT": 64}
SIGNED = frozenset({"SINT", "INT", "DINT", "LINT"})
VARIABLES = 3
LONG = replace(EPAS_4, name="epas-4 with 64 bits", has_long_types=True)


def cut(value: int, kind: str) -> int:
    bits = BITS[kind]
    value %= 2**bits
    return value - 2**bits if kind in SIGNED and value >= 2 ** (bits - 1) else value


def single(value: float) -> float:
    """The nearest number of single precision; what is too large is infinite."""
    try:
        (found,) = struct.unpack("<f", struct.pack("<f", value))
    except OverflowError:
        return math.copysign(math.inf, value)
    return float(found)


def quotient(a: int, b: int) -> int:
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


def remainder(a: int, b: int) -> int:
    return a - b * quotient(a, b)


@dataclass(frozen=True)
class Made:
    """An expression: its text, and its value for given variables; None after a division by zero."""

    text: str
    value: Callable[[list[float]], float | None]


INTEGER_OPERATORS: dict[str, Callable[[int, int], int]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": quotient,
    "MOD": remainder,
}


def two(left: Made, sign: str, right: Made, combine: Callable[[float, float], float]) -> Made:
    def value(variables: list[float]) -> float | None:
        a, b = left.value(variables), right.value(variables)
        if a is None or b is None or (sign in ("/", "MOD") and b == 0):
            return None
        return combine(a, b)

    return Made(f"({left.text} {sign} {right.text})", value)


WIDE = {"SINT": "DINT", "INT": "DINT", "USINT": "UDINT", "UINT": "UDINT"}
"""The types in which a 32-bit target computes; edition 3 computes in the types of the operands."""


def integers(kind: str) -> st.SearchStrategy[Made]:
    variable = st.integers(0, VARIABLES - 1).map(lambda number: Made(f"v{number}", lambda variables: variables[number]))

    def grow(inner: st.SearchStrategy[Made]) -> st.SearchStrategy[Made]:
        def combine(parts: tuple[Made, str, Made]) -> Made:
            left, sign, right = parts
            operate = INTEGER_OPERATORS[sign]
            return two(left, sign, right, lambda a, b: cut(operate(int(a), int(b)), kind))

        return st.tuples(inner, st.sampled_from(sorted(INTEGER_OPERATORS)), inner).map(combine)

    return st.recursive(variable, grow, max_leaves=6)


REAL_OPERATORS: dict[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}


def reals(round_: Callable[[float], float]) -> st.SearchStrategy[Made]:
    variable = st.integers(0, VARIABLES - 1).map(lambda number: Made(f"v{number}", lambda variables: variables[number]))

    def grow(inner: st.SearchStrategy[Made]) -> st.SearchStrategy[Made]:
        def combine(parts: tuple[Made, str, Made]) -> Made:
            left, sign, right = parts
            operate = REAL_OPERATORS[sign]
            return two(left, sign, right, lambda a, b: round_(operate(a, b)))

        return st.tuples(inner, st.sampled_from(sorted(REAL_OPERATORS)), inner).map(combine)

    return st.recursive(variable, grow, max_leaves=6)


def run(kind: str, made: list[Made], variables: list[list[float]], dialect: Dialect = LONG) -> None:
    """Run all expressions with each set of variables, and compare."""
    names = ", ".join(f"v{number}" for number in range(VARIABLES))
    results = ", ".join(f"r{number}" for number in range(len(made)))
    body = "\n".join(f"{number}: r{number} := {term.text};" for number, term in enumerate(made))
    text = program(f"which : INT; {names}, {results} : {kind};", f"CASE which OF\n{body}\nEND_CASE")
    bench = IecBench(text, dialect)
    for given_ in variables:
        for number, value in enumerate(given_):
            bench[f"v{number}"] = value
        for number, term in enumerate(made):
            bench["which"] = number
            bench.cycle()
            expected = term.value(given_)
            if expected is None:
                assert bench.thread.state is WorkState.FAULTED
                assert bench.thread.fault is not None
                assert bench.thread.fault.code == "division"
            else:
                expected = cut(int(expected), kind) if kind in BITS else expected
                assert bench.thread.state is WorkState.ENDED, bench.thread.fault
                assert same(bench[f"r{number}"], expected), (term.text, given_)


def same(found: Value, expected: float) -> bool:
    if isinstance(expected, float) and math.isnan(expected):
        return isinstance(found, float) and math.isnan(found)
    return type(found) is type(expected) and found == expected


@pytest.mark.long
@pytest.mark.manual("PD-367")
@pytest.mark.parametrize("dialect", [LONG, EDITION_3], ids=["32 bits", "edition-3"])
@pytest.mark.parametrize("kind", sorted(BITS))
@settings(max_examples=5, deadline=None)
@given(data=st.data())
def test_integers_wrap_around_in_their_register_after_every_operation(
    dialect: Dialect, kind: str, data: st.DataObject
) -> None:
    bits = BITS[kind]
    low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if kind in SIGNED else (0, 2**bits - 1)
    number = st.one_of(st.integers(low, high), st.sampled_from([low, high, 0, 1, cut(-1, kind), low + 1]))
    register = WIDE.get(kind, kind) if dialect is LONG else kind
    made = data.draw(st.lists(integers(register), min_size=1, max_size=16))
    variables = data.draw(st.lists(st.lists(number, min_size=VARIABLES, max_size=VARIABLES), min_size=1, max_size=6))
    run(kind, made, variables, dialect)


@pytest.mark.long
@pytest.mark.parametrize(("kind", "width"), [("REAL", 32), ("LREAL", 64)])
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_real_numbers_are_rounded_after_every_operation(kind: str, width: int, data: st.DataObject) -> None:
    number = (
        st.one_of(st.floats(width=32, allow_nan=False), st.sampled_from([0.0, 1.0, -1.5, 1e38, 2.0**-126, 2.0**-149]))
        if width == 32
        else st.floats(allow_nan=False)
    )
    number = number.map(single) if width == 32 else number
    made = data.draw(st.lists(reals(single if width == 32 else float), min_size=1, max_size=16))
    variables = data.draw(st.lists(st.lists(number, min_size=VARIABLES, max_size=VARIABLES), min_size=1, max_size=6))
    run(kind, made, variables)


@pytest.mark.parametrize("sign", ["<", "<=", "=", "<>", ">", ">="])
def test_comparisons(sign: str) -> None:
    bench = IecBench(program("a, b : INT; x, y : REAL; s, t : STRING; r : ARRAY[0..2] OF BOOL;",
        f"r[0] := a {sign} b; r[1] := x {sign} y; r[2] := s {sign} t;"))  # fmt: skip
    meaning = {"=": "==", "<>": "!="}.get(sign, sign)
    for first, second in ((1, 2), (2, 2), (3, 2)):
        bench["a"], bench["b"] = first, second
        bench["x"], bench["y"] = first / 2, second / 2
        bench["s"], bench["t"] = "abc"[:first], "abc"[:second]
        bench.cycle()
        expected = {"<": first < second, "<=": first <= second, "==": first == second, "!=": first != second,
                    ">": first > second, ">=": first >= second}[meaning]  # fmt: skip
        assert [bench[f"r[{number}]"] for number in range(3)] == [expected] * 3


BIT_CASES = [
    # type, expression, a, b, result; bit strings of the standard's truth tables
    ("BYTE", "a AND b", 0b1100, 0b1010, 0b1000),
    ("BYTE", "a OR b", 0b1100, 0b1010, 0b1110),
    ("BYTE", "a XOR b", 0b1100, 0b1010, 0b0110),
    ("BYTE", "NOT a", 0b1100, 0, 0b1111_0011),
    ("WORD", "NOT a", 1, 0, 0xFFFE),
    ("DWORD", "NOT a", 0, 0, 0xFFFF_FFFF),
    ("INT", "NOT a", 5, 0, -6),
    ("INT", "a AND b", -1, 0x7F, 0x7F),
    ("INT", "-a", -32768, 0, -32768),
    ("SINT", "-a", -128, 0, -128),
    ("BOOL", "a AND b", True, False, False),
    ("BOOL", "a OR b", True, False, True),
    ("BOOL", "a XOR b", True, True, False),
    ("BOOL", "NOT a", True, True, False),
]


@pytest.mark.parametrize(("kind", "text", "a", "b", "expected"), BIT_CASES)
def test_bit_operations_are_as_wide_as_their_type(kind: str, text: str, a: Value, b: Value, expected: Value) -> None:
    bench = IecBench(program(f"a, b, r : {kind};", f"r := {text};"))
    bench["a"], bench["b"] = a, b
    bench.cycle()
    assert bench["r"] == expected
    assert type(bench["r"]) is type(expected)


def test_a_function_changes_its_own_inputs_and_not_the_variables_of_the_caller() -> None:
    gcd = """
        FUNCTION Gcd : DINT
        VAR_INPUT a, b : DINT; END_VAR
        VAR t : DINT; END_VAR
        WHILE b <> 0 DO t := a MOD b; a := b; b := t; END_WHILE;
        Gcd := a;
        END_FUNCTION
        """
    bench = IecBench(program("x : DINT; y : DINT := 1071;", "x := Gcd(y, 462);") + gcd, EDITION_3)
    bench.cycle()
    assert (bench["x"], bench["y"]) == (math.gcd(1071, 462), 1071)
