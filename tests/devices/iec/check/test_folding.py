"""Constant expressions, against an evaluator of their own: Python integers, fractions, and floats rounded by struct."""

import struct
from dataclasses import dataclass
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_check import checked, program, variables

RANGES = {
    "SINT": (-(2**7), 2**7 - 1), "INT": (-(2**15), 2**15 - 1), "DINT": (-(2**31), 2**31 - 1), "USINT": (0, 2**8 - 1),
    "UINT": (0, 2**16 - 1), "UDINT": (0, 2**32 - 1), "BYTE": (0, 2**8 - 1), "WORD": (0, 2**16 - 1),
    "DWORD": (0, 2**32 - 1),
}  # fmt: skip


def wrapped(value: int, kind: str) -> int:
    low, high = RANGES[kind]
    return (value - low) % (high - low + 1) + low


WIDE = {"SINT": "DINT", "INT": "DINT", "USINT": "UDINT", "UINT": "UDINT", "BYTE": "DWORD", "WORD": "DWORD"}
"""The type in which a 32-bit target computes."""


def towards_zero(value: Fraction) -> int:
    return int(value)  # int() of a Fraction cuts the places behind the point off


@dataclass(frozen=True)
class Case:
    text: str
    value: int
    """Before it is stored."""


def typed(value: int, kind: str) -> str:
    """A literal of a type; a minus sign would be an operator, so negative numbers are written as their bits."""
    low, high = RANGES[kind]
    return f"{kind}#16#{value % (high - low + 1):X}"


@st.composite
def integer_cases(draw: st.DrawFn, kind: str, depth: int = 4) -> Case:
    low, high = RANGES[kind]
    if depth == 0 or draw(st.booleans()):
        value = draw(st.one_of(st.integers(low, high), st.sampled_from([low, high, 0, 1])))
        return Case(typed(value, kind), value)
    left = draw(integer_cases(kind, depth - 1))
    operators = ["+", "-", "*", "/", "MOD", "AND", "OR", "XOR"]
    operator = draw(st.sampled_from([*operators, "NOT"] + ["-x"] * (low < 0)))
    if operator == "NOT":
        return Case(f"NOT ({left.text})", wrapped(~wrapped(left.value, kind), kind))
    if operator == "-x":
        return Case(f"-({left.text})", wrapped(-left.value, WIDE.get(kind, kind)))
    right = draw(integer_cases(kind, depth - 1))
    if operator in ("/", "MOD") and right.value == 0:
        operator = "+"
    quotient = towards_zero(Fraction(left.value, right.value)) if operator in ("/", "MOD") else 0
    value = {
        "+": left.value + right.value,
        "-": left.value - right.value,
        "*": left.value * right.value,
        "/": quotient,
        "MOD": left.value - quotient * right.value,
        "AND": left.value & right.value,
        "OR": left.value | right.value,
        "XOR": left.value ^ right.value,
    }[operator]
    return Case(f"({left.text} {operator} {right.text})", wrapped(value, WIDE.get(kind, kind)))


@pytest.mark.long
@pytest.mark.parametrize("kind", RANGES)
def test_integers_wrap_around_in_32_bits_and_then_in_their_type(kind: str) -> None:
    @settings(max_examples=15, deadline=None)
    @given(st.lists(integer_cases(kind), min_size=5, max_size=10))
    def agree(cases: list[Case]) -> None:
        found = variables(
            "".join(f"x{number} : {kind} := {case.text};" for number, case in enumerate(cases)), with_libraries=False
        )
        assert [variable.initial for variable in found.values()] == [wrapped(case.value, kind) for case in cases]

    agree()


def single(value: Fraction) -> Fraction:
    """The nearest REAL, by IEEE 754: struct rounds a double, and a double holds sum and product of two singles exactly
    enough for a second rounding to be the same (Figueroa, 1995: 53 >= 2 * 24 + 2)."""
    (rounded,) = struct.unpack("<f", struct.pack("<f", float(value)))
    return Fraction(rounded)


@st.composite
def real_cases(draw: st.DrawFn, depth: int = 4) -> tuple[str, Fraction]:
    if depth == 0 or draw(st.booleans()):
        thousandths = draw(st.integers(1, 99_999))
        return f"REAL#{thousandths // 1000}.{thousandths % 1000:03}", single(Fraction(thousandths, 1000))
    (left, a), (right, b) = draw(real_cases(depth - 1)), draw(real_cases(depth - 1))
    operator = draw(st.sampled_from("+-*/" if b else "+-*"))
    exact = {"+": a + b, "-": a - b, "*": a * b, "/": a / b if b else Fraction(0)}[operator]
    return f"({left} {operator} {right})", single(exact)


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(st.lists(real_cases(), min_size=5, max_size=10))
def test_reals_are_rounded_to_single_precision_after_each_operation(cases: list[tuple[str, Fraction]]) -> None:
    found = variables(
        "".join(f"x{number} : REAL := {text};" for number, (text, _) in enumerate(cases)), with_libraries=False
    )
    assert [Fraction(float(str(variable.initial))) for variable in found.values()] == [value for _, value in cases]


@st.composite
def literal_cases(draw: st.DrawFn, depth: int = 4) -> Case:
    if depth == 0 or draw(st.booleans()):
        value = draw(st.integers(0, 2**40))
        return Case(str(value), value)
    left, right = draw(literal_cases(depth - 1)), draw(literal_cases(depth - 1))
    operator = draw(st.sampled_from(["+", "-", "*", "/", "MOD"] if right.value else ["+", "-", "*"]))
    quotient = towards_zero(Fraction(left.value, right.value)) if right.value else 0
    value = {
        "+": left.value + right.value,
        "-": left.value - right.value,
        "*": left.value * right.value,
        "/": quotient,
        "MOD": left.value - quotient * right.value,
    }[operator]
    return Case(f"({left.text} {operator} {right.text})", value)


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(literal_cases())
def test_literals_alone_are_computed_exactly_and_must_fit_in_the_end(case: Case) -> None:
    found, mistakes = checked(program(f"x : DINT := {case.text};"), with_libraries=False)
    assert bool([mistake for mistake in mistakes if not mistake.is_note]) == (not -(2**31) <= case.value < 2**31)
    if not [mistake for mistake in mistakes if not mistake.is_note]:
        assert found.pous["plc_prg"].variables["x"].initial == case.value


FUNCTIONS = [
    ("INT", "INT_TO_SINT(4223)", 127),  # PD-L39
    ("INT", "REAL_TO_INT(1.5)", 2),  # PD-L40
    ("INT", "REAL_TO_INT(1.4)", 1),
    ("INT", "TRUNC(1.9)", 1),  # PD-L44
    ("INT", "TRUNC(-1.4)", -1),
    ("DWORD", "TIME_TO_DWORD(T#5m)", 300_000),  # PD-L41
    ("INT", "DATE_TO_INT(D#1970-01-15)", 29_952),  # PD-L42
    ("INT", "EXPT(7, 2)", 49),  # PD-L45
    ("INT", "MAX(30, 90, 40, 77)", 90),  # PD-L33
    ("INT", "LIMIT(30, 90, 80)", 80),
    ("INT", "SEL(TRUE, 3, 4)", 4),
    ("INT", "MUX(0, 30, 40, 50, 60, 70, 80)", 30),
    ("INT", "7 * 2 * 4 * 7", 392),  # PD-L27
    ("INT", "9 MOD 2", 1),
    ("TIME", "T#45s + T#50s", 95_000),
    ("BYTE", "2#1001_0011 AND 2#1000_1010", 0b1000_0010),  # PD-L29
    ("BYTE", "2#1001_0011 OR 2#1000_1010", 0b1001_1011),
    ("BYTE", "2#1001_0011 XOR 2#1000_1010", 0b0001_1001),
    ("BYTE", "NOT 2#1001_0011", 0b0110_1100),
    ("BYTE", "ROL(BYTE#2#1001_0011, 3)", 0b1001_1100),  # PD-L32
    ("BYTE", "ROR(BYTE#2#1001_0011, 3)", 0b0111_0010),
    ("BOOL", "20 < 30", True),  # PD-L34
    ("BOOL", "40 <> 40", False),
    ("BOOL", "'abc' < 'abd'", True),
    ("TIME", "T#10s * 2.5", 25_000),
    ("TIME", "T#10s / 4", 2_500),
    ("DT", "DT#1970-01-01-00:00:10 + T#5s", 15),
    ("TIME", "D#1970-01-03 - D#1970-01-01", 172_800_000),
    ("INT", "SIZEOF(ARR)", 10),  # PD-L28
    ("INT", "SIZEOF(INT)", 2),
]


@pytest.mark.parametrize(("kind", "expression", "expected"), FUNCTIONS)
def test_functions_of_constants_are_constants(kind: str, expression: str, expected: object) -> None:
    found = variables(f"x : {kind} := {expression};", "TYPE ARR : ARRAY[0..4] OF INT; END_TYPE")
    assert found["x"].initial == expected


def test_a_division_by_zero_is_left_to_the_run_time() -> None:
    found, mistakes = checked(program("x : INT; y : INT;", "x := 3; y := x / 0;"))  # PD-L53
    assert [mistake.what for mistake in mistakes[1:]] == ["this is a division by zero"]
    assert all(mistake.is_note for mistake in mistakes)
    assert len(found.pous["plc_prg"].body) == 2


@pytest.mark.parametrize("value", ["1 / 0", "7 MOD (2 - 2)", "1.5 / 0.0", "c / 0", "INT#4 / INT#0"])
def test_a_division_of_constants_by_zero_is_a_mistake(value: str) -> None:
    text = program(
        "x : REAL; y : INT; END_VAR VAR CONSTANT c : INT := 3;", f"{'x' if '.' in value else 'y'} := {value};"
    )
    _, mistakes = checked(text)
    assert [mistake.what for mistake in mistakes if not mistake.is_note] == ["this is a division by zero"]


def test_a_division_by_zero_is_no_start_value() -> None:
    _, mistakes = checked(program("x : INT := 1 / 0;"))
    assert [mistake.what for mistake in mistakes if not mistake.is_note] == ["this is a division by zero"]
