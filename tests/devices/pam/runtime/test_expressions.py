"""Expressions of running programs: numbers, faults, and the functions of chapter 6."""

import math
import operator
from collections.abc import Callable
from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pam_bench import OBJECTS, PamBench, computed, sequence

from fieldrig_devices.pam.language.tree import Binary, Expression, Number, Place, Unary
from fieldrig_devices.pam.runtime.arithmetic import quotient, remainder

AT = Place("", 0, 0)


def value(expression: str, target: str = "x", **values: float) -> object:
    return computed(f"{target} <- {expression};", **values)[target]


@pytest.mark.manual("PAMS-001", "PAMS-004", "PAMS-007")
@pytest.mark.parametrize(
    ("expression", "y", "expected"),
    [  # case T01, manual lines 6559 to 6585
        ("Pi ? sin", 0.0, 1.2246e-16),
        ("2 * y + 23 ? cos", 1.0, 1.46716697),
        ("(y / 2) ? tan * 3", 1.0, 1.63890747),
        ("(y ? sin * 2) ? asin", 0.2, 0.40861492),
    ],
)
def test_mathematics_of_the_manual(expression: str, y: float, expected: float) -> None:
    assert value(expression, y=y) == pytest.approx(expected, rel=1e-4 if y == 0 else 1e-8)


@pytest.mark.manual("PAMS-006", "PAMS-008")
@pytest.mark.parametrize(
    ("expression", "expected"),
    [  # case T02, manual lines 6647 to 6685
        ("2 * 3 ^ 2", 36),
        ("2 ^ 3 * 4", 32),
        ("7 % 3", 1),
        ("-7 % 3", -1),
        ("7 % 0", 7),
        ("n % 3", -1),
        ("n % w", -7),
        ("0 ^ 2", 0),
        ("5 ^ 0", 1),
        ("7 / 2", 3),
        ("-7 / 2", -3),
        ("8000 / 1000", 8),
        ("2.9", 2),
        ("-2.9", -2),
        ("#29 + 1", 42),
    ],
)
def test_integers(expression: str, expected: int) -> None:
    assert value(expression, "at", n=-7) == expected


@pytest.mark.manual("PAMS-002", "PAMS-003", "PAMS-005")
@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("-2.5 ? abs", 2.5),
        ("2.1 ? ceil", 3.0),
        ("-2.1 ? floor", -3.0),
        ("1 ? exp", math.e),
        ("100 ? log10", 2.0),
        ("2 ? ln", math.log(2)),
        ("2 ? sqrt", math.sqrt(2)),
        ("1 ? acos", 0.0),
        ("1 ? atan", math.pi / 4),
        ("1 ? cosh", math.cosh(1)),
        ("1 ? sinh", math.sinh(1)),
        ("1 ? tanh", math.tanh(1)),
        ("-1000 ? tanh", -1.0),
    ],
)
def test_functions(expression: str, expected: float) -> None:
    found = value(expression)
    assert found == pytest.approx(expected)
    assert isinstance(found, float)


@pytest.mark.manual("PAML-228", "PAMS-104")
@pytest.mark.parametrize(
    ("assignment", "code"),
    [
        ("n <- w + 2147483647;", "02..FFF2"),
        ("n <- -w * 2 * 1073741824 - 1;", "02..FFF2"),
        ("n <- 5 / (w - 1);", "02..FFF2"),
        ("n <- 3000000000.0 * w;", "02..FFF2"),
        ("n <- (2147483647 * w + 1) / 2;", "02..FFF2"),
        ("x <- 1.0 / (w - 1);", "02..FFF3"),
        ("x <- (w * 700 ? exp) * (w * 700 ? exp);", "02..FFF3"),
        ("x <- 1 / ((w * 700 ? exp) * (w * 700 ? exp));", "02..FFF3"),
        ("x <- (-w) ? sqrt;", "02..FFF3"),
        ("x <- 0 ? ln;", "02..FFF3"),
        ("x <- (w * 2) ? asin;", "02..FFF3"),
        ("x <- (w * 1000) ? exp;", "02..FFF3"),
        ("x <- 0 ^ (-w);", "02..FFF3"),
        ("x <- (-w) ^ 0.5;", "02..FFF3"),
    ],
)
def test_arithmetic_faults_stop_the_application(assignment: str, code: str) -> None:
    bench = computed(assignment + " at <- 1;", w=1)
    assert bench.errors == [code]
    assert bench["at"] == 0
    assert bench.runtime.fault is not None
    assert (bench.runtime.fault.title, bench.runtime.is_stopped) == ("TSK_a.SEQ_a", True)


@pytest.mark.manual("PAML-222", "PAML-223", "PAML-227")
def test_conversions() -> None:
    bench = computed("n <- 2147483647; w <- -n - 1; x <- n; y <- 7 / 2 * 1.5; r <- 3; at <- y; cf <- 1;")
    names = ("n", "w", "x", "y", "r", "at", "cf")
    assert [bench[name] for name in names] == [2147483647, -2147483648, 2147483647.0, 4.5, 3.0, 4, True]


def test_the_lowest_integer_is_written_with_its_sign() -> None:
    bench = computed("n <- -2147483648; w <- 2147483648; x <- -2147483648;")
    assert [bench[name] for name in ("n", "w", "x")] == [-2147483648, -2147483648, -2147483648.0]


@pytest.mark.manual("PAML-227")
def test_reals_keep_their_type() -> None:
    bench = computed("r <- w; x <- r / 2; y <- w / 2;", w=3)
    assert (bench["x"], bench["y"]) == (1.5, 1.0)


def test_flags_and_comparisons() -> None:
    bench = computed("f <- (n > 2) * !(x < 1.5) + g; cf <- f = 1; h <- f <> g;", n=3, x=1.5)
    assert (bench["f"], bench["cf"], bench["h"]) == (True, True, True)


@pytest.mark.parametrize(
    ("mask", "value"),
    [  # case T21, manual lines 8845 to 8860 and 8921 to 9010
        ("HARD_ERROR", 0x00F81000),
        ("SUPPLY_ERROR", 0x00180000),
        ("OUT_OVERTEMP", 0x70),
        ("DCMOTOR_ABORT_ERROR", 0x7),
    ],
)
def test_masks_of_errors(mask: str, value: int) -> None:
    directives = (
        '#include "ST1ERROR.SYS"\n#include "SMARTERR.SYS"\n#undef OUT_OVERTEMP\n'
        "#set OUT_OVERTEMP OUT_OVERTEMP_1 | \\\n  OUT_OVERTEMP_2\n#set BOTH OUT_OVERTEMP\n#undef OUT_OVERTEMP\n"
        "#set OUT_OVERTEMP OUT_OVERTEMP_1 | OUT_OVERTEMP_2 | OUT_OVERTEMP_3\n"
    )
    bench = PamBench(
        sequence(f"w <- {mask}; n <- BOTH; f <- AXI_Each[all+] ? error_code({mask});"), header=directives + OBJECTS
    )
    asked: list[object] = []

    def ask(function: str, arguments: object) -> bool:
        asked.append(arguments)
        return True

    bench.item("AXI_Each").ask = ask  # type: ignore[method-assign]
    bench.restart()
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert (bench["w"], bench["n"], asked) == (value, 0x30, [(value,)])


def test_words_of_errors_have_a_sign_as_all_integers() -> None:
    bench = PamBench(
        "BOOLEAN BOL_a; EQUATION = (AXI_Each[i] ? error_code = #80000001)[all*]; END_BOOLEAN\n"
        + sequence("IF BOL_a THEN w <- 1; END_IF n <- #80000001;")
    )
    for number in (0, 1):
        bench.item("AXI_Each", number).answer("error_code", 0x8000_0001)
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert (bench["w"], bench["n"]) == (1, 0x8000_0001 - 2**32)


# ---- random expressions against an exact evaluator

NUMBERS = st.builds(lambda value: Number(AT, value, str(value)), st.integers(0, 100_000))


def _binary(inner: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    joined = st.builds(lambda sign, a, b: Binary(AT, sign, a, b), st.sampled_from("+-*/%"), inner, inner)
    return joined | st.builds(lambda a: Unary(AT, "-", a), inner)


EXPRESSIONS = st.recursive(NUMBERS, _binary, max_leaves=12)


def text_of(expression: Expression) -> str:
    match expression:
        case Number(spelling=spelling):
            return spelling
        case Unary(operand=operand):
            return f"(-{text_of(operand)})"
        case Binary(operator=operator, left=left, right=right):
            return f"({text_of(left)} {operator} {text_of(right)})"
    raise AssertionError(expression)


class NoIntegerError(Exception):
    """The exact evaluator has found a result that is no integer of 32 bits."""


def exact(expression: Expression) -> int:
    match expression:
        case Number(value=value):
            result = Fraction(value)
        case Unary(operand=operand):
            result = -Fraction(exact(operand))
        case Binary(operator=operator, left=left, right=right):
            result = _exact(operator, Fraction(exact(left)), Fraction(exact(right)))
        case _:
            raise AssertionError(expression)
    if not -(2**31) <= result < 2**31:
        raise NoIntegerError
    return int(result)


def _exact(operator: str, a: Fraction, b: Fraction) -> Fraction:
    match operator:
        case "+":
            return a + b
        case "-":
            return a - b
        case "*":
            return a * b
        case "%":
            return a if b == 0 else a - b * int(a / b)
    if b == 0:
        raise NoIntegerError
    return Fraction(int(a / b))


@pytest.mark.long
@settings(max_examples=30)
@given(st.lists(EXPRESSIONS, min_size=8, max_size=8))
def test_random_expressions_have_their_exact_values(expressions: list[Expression]) -> None:
    """Several in one application, because compiling takes longer than computing."""
    known = []
    for expression in expressions:
        try:
            known.append((expression, exact(expression)))
        except NoIntegerError:
            continue
    assume(known)
    bench = PamBench(
        "COMMON WORD_VAR v; NUMBER = 3; END\n"
        + "".join(f"COMMON WORD_VAR v{number};\n" for number in range(len(known)))
        + sequence("".join(f"v{number} <- {text_of(each)};\n" for number, (each, _) in enumerate(known)))
    )
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert bench.errors == []
    assert [bench[f"v{number}"] for number in range(len(known))] == [expected for _, expected in known]


@settings(max_examples=15)
@given(EXPRESSIONS)
def test_a_fault_is_found_where_the_exact_evaluator_finds_it(expression: Expression) -> None:
    bench = computed(f"n <- {text_of(expression)};")
    try:
        expected = exact(expression)
    except NoIntegerError:
        assert bench.errors == ["02..FFF2"]
    else:
        assert (bench.errors, bench["n"]) == ([], expected)


@given(st.integers(-(2**31), 2**31 - 1), st.integers(-(2**31), 2**31 - 1).filter(bool))
def test_quotient_and_remainder_fit_together(a: int, b: int) -> None:
    assume((a, b) != (-(2**31), -1))
    assert quotient(a, b) * b + remainder(a, b) == a
    assert abs(remainder(a, b)) < abs(b)


# ---- random reals and flags, each with its value, or None for what has no finite one

LARGE = "1" + "0" * 200 + ".0"
Real = tuple[str, float | None]
REAL_SIGNS: dict[str, Callable[[float, float], float]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
}


def joined_reals(sign: str, a: Real, b: Real) -> Real:
    text = f"({a[0]} {sign} {b[0]})"
    if a[1] is None or b[1] is None or (sign == "/" and b[1] == 0):
        return text, None
    result = REAL_SIGNS[sign](a[1], b[1])
    return text, result if math.isfinite(result) else None


REALS = st.recursive(
    st.sampled_from([(text, float(text)) for text in ("0.0", "1.5", "3.25", "0.001", LARGE)]),
    lambda inner: st.builds(joined_reals, st.sampled_from("+-*/"), inner, inner),
    max_leaves=8,
)


@settings(max_examples=30)
@given(REALS)
def test_reals_are_doubles_and_an_infinite_one_is_a_fault(real: Real) -> None:
    text, expected = real
    bench = computed(f"x <- {text};")
    assert (bench.errors, bench["x"]) == (["02..FFF3"], 0.0) if expected is None else ([], expected)


Flag = tuple[str, bool]
FLAG_SIGNS: dict[str, Callable[[bool, bool], bool]] = {
    "+": operator.or_,
    "*": operator.and_,
    "=": operator.eq,
    "<>": operator.ne,
}


def joined_flags(sign: str, a: Flag, b: Flag) -> Flag:
    return f"({a[0]} {sign} {b[0]})", FLAG_SIGNS[sign](a[1], b[1])


FLAGS = st.recursive(
    st.sampled_from([("f", True), ("g", False), ("(n > 2)", True), ("(x <= 1.5)", False), ("SBI_a", True)]),
    lambda inner: (
        st.builds(joined_flags, st.sampled_from(["+", "*", "=", "<>"]), inner, inner)
        | st.builds(lambda a: (f"(!{a[0]})", not a[1]), inner)
    ),
    max_leaves=10,
)


@pytest.mark.long
@settings(max_examples=30)
@given(FLAGS)
def test_flags_are_joined_as_the_signs_say(flag: Flag) -> None:
    bench = computed(f"h <- {flag[0]};", f=True, n=3, x=2.0)
    assert bench["h"] is flag[1]
