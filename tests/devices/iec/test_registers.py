"""A 32-bit target computes in its registers, and cuts a result where it is stored or converted, and nowhere before.

The expected values come from arithmetic that is written here after CODESYS Online Help, "Operators", overflow and
underflow in the data type; its four examples are the first test.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.types import Value

LONG = replace(EPAS_4, name="epas-4 with 64 bits", has_long_types=True)
SIGNED = {8: "SINT", 16: "INT", 32: "DINT", 64: "LINT"}
UNSIGNED = {8: "USINT", 16: "UINT", 32: "UDINT", 64: "ULINT"}
BITS = {name: bits for names in (SIGNED, UNSIGNED) for bits, name in names.items()}
VARIABLES = {f"v{number}": kind for number, kind in enumerate(BITS)}


def run(declarations: str, body: str, dialect: Dialect = CODESYS) -> Value:
    bench = IecBench(program(declarations, body), dialect)
    bench.cycle()
    assert bench.thread.fault is None
    return bench["r"]


# ---- what the documentation of CODESYS shows


@pytest.mark.parametrize(
    ("declarations", "body", "expected"),
    [
        ("w : WORD := 65535; r : DWORD;", "r := w + 1;", 65_536),
        ("w : WORD := 65535; z : WORD; r : BOOL;", "r := (w + 1) = z;", False),
        ("w : WORD := 65535; z : WORD; r : BOOL;", "r := (z - 1) = w;", False),
        ("w, x : WORD := 65535; z : WORD; r : BOOL;", "x := w + 1; r := x = z;", True),
        ("w : WORD := 65535; z : WORD; r : BOOL;", "r := TO_WORD(w + 1) = z;", True),
        ("w : WORD := 65535; z : WORD; r : BOOL;", "r := TO_WORD(z - 1) = w;", True),
        ("u : USINT; r : BOOL;", "r := u - 1 <> 255;", True),  # Static Analysis, SA0066
        ("u : USINT; r : BOOL;", "r := TO_USINT(u - 1) <> 255;", False),
        ("d : DINT := 100000; r : LINT;", "r := d * d;", 1_410_065_408),  # SA0130
        ("d : DINT := 100000; r : LINT;", "r := TO_LINT(d) * TO_LINT(d);", 10_000_000_000),
        ("b : BYTE := 16#45; r : WORD;", "r := SHL(b, 2);", 0x14),  # SHL: as wide as the type of the input
        ("i : INT := 2; j : INT := 7; r : LREAL;", "r := EXPT(i, j);", 128.0),
        ("i : INT := 10; j : INT := 5; r : LREAL;", "r := EXPT(i, j);", 100_000.0),  # "return type is always LREAL"
        ("i : INT := 2; r : REAL;", "r := EXPT(i, -1);", 0.5),
        ("i : INT := 2; r : BOOL;", "r := EXPT(i, -1) > 0;", True),
        ("x : REAL := 0.1; r : LREAL;", "r := EXPT(x, 1);", 0.10000000149011612),
    ],
)
def test_examples_of_the_documentation(declarations: str, body: str, expected: Value) -> None:
    assert run(declarations, body) == expected


@pytest.mark.parametrize("dialect", [EPAS_4, CODESYS], ids=lambda dialect: dialect.name)
@pytest.mark.parametrize(
    ("declarations", "body", "expected"),
    [
        ("i : INT := 30000; r : DINT;", "r := INT_TO_DINT(i + i);", 60_000),
        ("i : INT := 30000; r : REAL;", "r := INT_TO_REAL(i + i);", 60_000.0),
        ("i : INT := 30000; r : STRING;", "r := INT_TO_STRING(i + i);", "60000"),
        ("i : INT := 30000; r : TIME;", "r := INT_TO_TIME(i + i);", 60_000),
        ("i : INT := 30000; r : WORD;", "r := INT_TO_WORD(i + i);", 60_000),
        ("i : INT := 30000; r : INT;", "r := TO_INT(i + i);", -5_536),
        ("i : INT := -1; r : DINT;", "r := WORD_TO_DINT(i + i);", 65_534),  # a name with another sign cuts
        ("b : BYTE := 200; r : DINT;", "r := BYTE_TO_DINT(b * b);", 40_000),
        ("u : UINT := 32768; r : BOOL;", "r := UINT_TO_BOOL(u + u);", True),
        ("u : UINT := 40000; v : UINT := 50000; r : UINT;", "r := SHR(u + v, 1);", 45_000),
        ("w : WORD := 16#F001; r : WORD;", "r := ROL(w + 0, 1);", 0xE003),
        ("i : SINT := -128; r : DINT;", "r := SINT_TO_DINT(-i);", 128),
        ("i : INT := -32768; r : DINT;", "r := ABS(i);", 32_768),
        ("i : INT := 300; r : DINT;", "r := EXPT(i, 2);", 90_000),
        ("u : USINT := 255; r : DINT;", "r := -(u * u);", -65_025),
    ],
)
def test_a_result_is_not_cut_before_a_conversion(
    dialect: Dialect, declarations: str, body: str, expected: Value
) -> None:
    assert run(declarations, body, dialect) == expected


def test_edition_3_computes_in_the_type_of_the_operands() -> None:
    assert run("i : INT := 30000; r : DINT;", "r := TO_DINT(i + i);", EDITION_3) == -5_536
    assert run("i : INT := 300; r : DINT;", "r := EXPT(i, 2);", EDITION_3) == 24_464


def test_a_power_of_integers_is_no_integer_where_none_is_wanted() -> None:
    messages = refused(program("a : ARRAY[0..9] OF INT; i, r : INT;", "r := a[EXPT(i, 2)];"), CODESYS)
    assert any("LREAL" in message for message in messages), messages


# ---- random expressions in every place that takes a value


def cut(value: int, kind: str) -> int:
    value %= 2 ** BITS[kind]
    return value - 2 ** BITS[kind] if kind in SIGNED.values() and value >= 2 ** (BITS[kind] - 1) else value


def register(kind: str) -> str:
    names = SIGNED if kind in SIGNED.values() else UNSIGNED
    return names[max(BITS[kind], 32)]


@dataclass(frozen=True)
class Made:
    """An expression with its type in the source, and its value in the register for given variables."""

    text: str
    kind: str
    value: Callable[[dict[str, int]], int]


def _met(left: str, right: str) -> str:
    bits = max(BITS[left], BITS[right])
    return (SIGNED if SIGNED[BITS[left]] == left or SIGNED[BITS[right]] == right else UNSIGNED)[bits]


OPERATORS: dict[str, Callable[[int, int], int]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "AND": lambda a, b: a & b,
    "OR": lambda a, b: a | b,
    "XOR": lambda a, b: a ^ b,
}


def _two(left: Made, sign: str, right: Made) -> Made:
    kind = _met(left.kind, right.kind)
    wide, operate = register(kind), OPERATORS[sign]
    if sign in ("AND", "OR", "XOR"):  # logic of two variables stays within their type
        is_variable = left.text in VARIABLES and right.text in VARIABLES
        wide = kind if is_variable else wide

    def value(given_: dict[str, int]) -> int:
        return cut(operate(cut(left.value(given_), wide), cut(right.value(given_), wide)), wide)

    return Made(f"({left.text} {sign} {right.text})", kind, value)


def _minus(inner: Made) -> Made:
    bits = BITS[inner.kind]
    kind = inner.kind if inner.kind == SIGNED[bits] else SIGNED[min(64, max(16, bits * 2))]
    return Made(f"(-{inner.text})", kind, lambda given_: cut(-inner.value(given_), register(kind)))


def _absolute(inner: Made) -> Made:
    return Made(f"ABS({inner.text})", inner.kind, lambda given_: cut(abs(inner.value(given_)), register(inner.kind)))


def _converted(inner: Made, kind: str) -> Made:
    return Made(f"TO_{kind}({inner.text})", kind, lambda given_: cut(inner.value(given_), kind))


def _grow(inner: st.SearchStrategy[Made]) -> st.SearchStrategy[Made]:
    return st.one_of(
        st.builds(_two, inner, st.sampled_from(sorted(OPERATORS)), inner),
        st.builds(_minus, inner),
        st.builds(_absolute, inner),
        st.builds(_converted, inner, st.sampled_from(sorted(BITS))),
    )


def _variable(name: str) -> Made:
    return Made(name, VARIABLES[name], lambda given_: given_[name])


EXPRESSIONS = st.recursive(st.sampled_from(sorted(VARIABLES)).map(_variable), _grow, max_leaves=5)

FUNCTION = "FUNCTION Same : LINT VAR_INPUT x : LINT; END_VAR Same := x; END_FUNCTION\n"
BLOCK = "FUNCTION_BLOCK Keep VAR_INPUT x : LINT; END_VAR END_FUNCTION_BLOCK\n"


def _everywhere(made: Made, number: int) -> str:
    """Statements that bring the value to every kind of place."""
    cases = " ".join(f"{low}: selected := {low};" for low in range(4))
    return f"""{number}:
        assigned := {made.text}; converted := TO_LINT({made.text}); shown := TO_STRING({made.text});
        argument := Same({made.text}); keep(x := {made.text}); long_real := TO_LREAL({made.text});
        is_same := {made.text} = assigned; indexed := table[{made.text} AND 3];
        CASE {made.text} AND 3 OF {cases} END_CASE
        FOR bound := {made.text} TO {made.text} DO looped := bound; EXIT; END_FOR"""


def _in_all_places(value: int) -> dict[str, Value]:
    stored, low = cut(value, "LINT"), value & 3
    numbers = dict.fromkeys(("assigned", "converted", "argument", "keep.x", "looped"), stored)
    return {**numbers, "shown": str(value), "long_real": float(value), "is_same": stored == value, "indexed": low,
            "selected": low}  # fmt: skip


@pytest.mark.long
@pytest.mark.manual("PD-367")
@pytest.mark.parametrize("dialect", [LONG, CODESYS], ids=lambda dialect: dialect.name)
@settings(max_examples=20, deadline=None)
@given(data=st.data())
def test_every_place_gets_the_whole_value(dialect: Dialect, data: st.DataObject) -> None:
    made = data.draw(st.lists(EXPRESSIONS, min_size=1, max_size=6))
    declared = " ".join(f"{name} : {kind};" for name, kind in VARIABLES.items())
    places = """which : INT; assigned, converted, argument, bound, looped : LINT; shown : STRING; keep : Keep;
        long_real : LREAL; is_same : BOOL; table : ARRAY[0..3] OF INT := 0, 1, 2, 3; indexed, selected : INT;"""
    body = "\n".join(_everywhere(term, number) for number, term in enumerate(made))
    text = FUNCTION + BLOCK + program(declared + places, f"CASE which OF\n{body}\nEND_CASE")
    bench = IecBench(text, dialect)
    for _ in range(3):
        given_ = {name: data.draw(_numbers(kind)) for name, kind in VARIABLES.items()}
        for name, number in given_.items():
            bench[name] = number
        for number, term in enumerate(made):
            bench["which"] = number
            bench.cycle()
            assert bench.thread.fault is None
            expected = _in_all_places(term.value(given_))
            assert {place: bench[place] for place in expected} == expected, (term.text, given_)


def _numbers(kind: str) -> st.SearchStrategy[int]:
    low, high = (
        (-(2 ** (BITS[kind] - 1)), 2 ** (BITS[kind] - 1) - 1) if kind in SIGNED.values() else (0, 2 ** BITS[kind] - 1)
    )
    return st.one_of(st.integers(low, high), st.sampled_from([low, high, 0, 1, high - 1]))
