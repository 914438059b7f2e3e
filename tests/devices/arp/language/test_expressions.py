"""Complete expressions: the compiled code against a model that computes them exactly, node by node."""

import math
from fractions import Fraction

import pytest
from arp_card import ArpBench
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp.language.printer import argument_text
from fieldrig_devices.arp.language.tree import Binary, Constant, Direct, Expression, Function, Indexed, Number, Unary

LIMIT = 999_999_999
VARIABLES = st.lists(
    st.one_of(st.integers(-LIMIT, LIMIT), st.integers(-9_999, 9_999), st.integers(-(2**31), 2**31 - 1)),
    min_size=4,
    max_size=4,
)
BITS = st.lists(st.integers(0, 1), min_size=4, max_size=4)
MANY = settings(max_examples=250, deadline=None)

NUMBERS: st.SearchStrategy[Expression] = st.recursive(
    st.one_of(
        st.integers(0, 9_999).map(Number),
        st.integers(0, 20).map(lambda whole: Number(whole * 1_000)),
        st.builds(Number, st.integers(-(2**31), 2**31 - 1), st.just(True)),
        st.just(Constant("PIG")),
        st.integers(1, 4).map(lambda number: Direct("V", number)),
        st.integers(1, 4).map(lambda number: Indexed("V", Direct("V", number + 10))),
    ),
    lambda inner: st.one_of(
        st.builds(Unary, st.sampled_from("-+!"), inner),
        st.builds(Binary, st.sampled_from(["|", "^", "&", "<<", ">>", "+", "-", "*", "/", "%"]), inner, inner),
        st.builds(Function, st.sampled_from(["SQR", "INT"]), inner),
    ),
    max_leaves=12,
)
SINGLE_BITS: st.SearchStrategy[Expression] = st.recursive(
    st.one_of(
        st.sampled_from(["HI", "LO", "ON", "OFF"]).map(Constant),
        st.sampled_from([0, 1_000]).map(Number),
        st.integers(1, 4).map(lambda number: Direct("F", number)),
        st.integers(1, 4).map(lambda number: Direct("I", 100 + number)),
    ),
    lambda inner: st.one_of(
        st.builds(Unary, st.just("!"), inner), st.builds(Binary, st.sampled_from("&|^"), inner, inner)
    ),
    max_leaves=12,
)


class Model:
    """Computes with exact rationals, limited to the range of the card after each operation."""

    def __init__(self, variables: list[int]) -> None:
        self._variables = variables
        self.warnings: list[int] = []

    def value(self, expression: Expression) -> int:
        match expression:
            case Number(raw):
                return raw
            case Constant():
                return 3_142
            case Direct(_, number):
                return self._variables[number - 1]
            case Indexed(_, Direct(_, number)):
                return self._variables[number - 11]
            case Unary("!", operand):
                return ~self.value(operand)
            case Unary("-", operand):
                return self._held(Fraction(-self.value(operand)))
            case Unary(_, operand):
                return self.value(operand)
            case Function("SQR", operand):
                return self._root(self.value(operand))
            case Function(_, operand):
                return math.trunc(Fraction(self.value(operand), 1_000)) * 1_000
            case Binary(sign, left, right):
                return self._binary(sign, self.value(left), self.value(right))
        raise AssertionError(expression)

    def _held(self, raw: Fraction) -> int:
        whole = math.trunc(raw)
        if abs(whole) <= LIMIT:
            return whole
        self.warnings.append(202)
        return LIMIT if whole > 0 else -LIMIT

    def _root(self, raw: int) -> int:
        if raw < 0:
            self.warnings.append(203)
            return 0
        return math.isqrt(raw * 1_000)

    def _binary(self, sign: str, a: int, b: int) -> int:
        match sign:
            case "&":
                return a & b
            case "|":
                return a | b
            case "^":
                return a ^ b
            case "<<" | ">>":
                return self._shifted(sign, a & 0xFFFF_FFFF, math.trunc(Fraction(b, 1_000)))
            case "+" | "-":
                return self._held(Fraction(a + b if sign == "+" else a - b))
            case "*":
                return self._held(Fraction(a * b, 1_000))
        if b == 0:
            self.warnings.append(201)
            return 0
        return self._held(Fraction(a * 1_000, b) if sign == "/" else a - b * Fraction(math.trunc(Fraction(a, b))))

    def _shifted(self, sign: str, word: int, places: int) -> int:
        if places < 0:
            self.warnings.append(203)
            return 0
        shifted = (word << min(places, 32) if sign == "<<" else word >> min(places, 32)) & 0xFFFF_FFFF
        return shifted - 2**32 if shifted >= 2**31 else shifted


@pytest.mark.long
@MANY
@given(expression=NUMBERS, variables=VARIABLES)
def test_a_compiled_expression_is_what_the_model_computes(expression: Expression, variables: list[int]) -> None:
    line = f"V9 == {argument_text(expression)}"
    if len(line) > 120:
        return
    bench = ArpBench(line)
    bench.card.V[1:5] = variables
    bench.card.V[11:15] = [1_000, 2_999, 3_500, 4_000]  # the integer part is the index
    bench.run()
    model = Model(variables)
    assert bench.card.V[9] == model.value(expression)
    assert sorted(bench.card.warnings) == sorted(model.warnings)


def bit(expression: Expression, bits: list[int]) -> int:
    match expression:
        case Constant(word):
            return int(word in ("HI", "ON"))
        case Number(raw):
            return raw // 1_000
        case Direct(_, number):
            return bits[number % 100 - 1]
        case Unary(_, operand):
            return 1 - bit(operand, bits)
        case Binary(sign, left, right):
            a, b = bit(left, bits), bit(right, bits)
            return {"&": a and b, "|": a or b, "^": int(a != b)}[sign]
    raise AssertionError(expression)


@pytest.mark.long
@MANY
@given(expression=SINGLE_BITS, bits=BITS)
def test_a_compiled_bit_expression_is_what_the_model_computes(expression: Expression, bits: list[int]) -> None:
    text = argument_text(expression)
    bench = ArpBench(f"F9 == {text}\nIF F10 | ({text}) = HI, SET F11\nIF {text} = F12, SET F13")
    bench.card.F[1:5] = bench.card.I[101:105] = bits
    bench.run()
    expected = bit(expression, bits)
    assert (bench.card.F[9], bench.card.F[11], bench.card.F[13]) == (expected, expected, 1 - expected)
    assert bench.card.warnings == []
