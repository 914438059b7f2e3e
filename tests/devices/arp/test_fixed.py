import math
from fractions import Fraction

import pytest
from arp_card import ArpBench
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp import fixed
from fieldrig_devices.arp.fixed import LIMIT, Arithmetic

RAW = st.integers(-LIMIT, LIMIT)
WORD = st.integers(-(2**31), 2**31 - 1)
LAWS = settings(max_examples=200, deadline=None)


def truncated(value: Fraction) -> int:
    return math.trunc(value)


def clamped(raw: int) -> tuple[int, list[int]]:
    """Result of an operation, and its warnings."""
    return (raw, []) if abs(raw) <= LIMIT else (LIMIT if raw > 0 else -LIMIT, [202])


class Computed:
    """One expression over V1 and V2, compiled once."""

    def __init__(self, expression: str) -> None:
        self._bench = ArpBench(f"V3 == {expression}")

    def __call__(self, a: int, b: int = 0) -> tuple[int, list[int]]:
        card = self._bench.card
        card.V[1], card.V[2] = a, b
        card.warnings.clear()
        self._bench.program.start()
        self._bench.run()
        return card.V[3], list(card.warnings)


ADD, SUBTRACT, MULTIPLY = Computed("V1 + V2"), Computed("V1 - V2"), Computed("V1 * V2")
DIVIDE, REMAIN = Computed("V1 / V2"), Computed("V1 % V2")
THRICE, THIRD, TENTH_OF, MINUS = Computed("V1 * 3"), Computed("V1 / 3"), Computed("V1 / 0.1"), Computed("-V1")
LEFT, RIGHT, COMPLEMENT = Computed("V1 << V2"), Computed("V1 >> V2"), Computed("!V1")
AND, OR, XOR = Computed("V1 & V2"), Computed("V1 | V2"), Computed("V1 ^ V2")
ROOT, WHOLE = Computed("SQR(V1)"), Computed("INT(V1)")


@pytest.mark.long
@pytest.mark.manual("ARP-052")
@LAWS
@given(a=RAW, b=RAW)
def test_sums_and_products_are_exact_truncated_and_held_within_the_range(a: int, b: int) -> None:
    assert ADD(a, b) == clamped(a + b)
    assert SUBTRACT(a, b) == clamped(a - b)
    assert MULTIPLY(a, b) == clamped(truncated(Fraction(a, 1000) * Fraction(b, 1000) * 1000))
    assert THRICE(a) == clamped(3 * a)
    assert MINUS(a) == clamped(-a)


@pytest.mark.long
@LAWS
@given(a=RAW, b=RAW.filter(bool))
def test_quotients_are_truncated_toward_zero(a: int, b: int) -> None:
    assert DIVIDE(a, b) == clamped(truncated(Fraction(a, b) * 1000))
    assert THIRD(a) == clamped(truncated(Fraction(a, 3)))
    assert TENTH_OF(a) == clamped(10 * a)
    assert REMAIN(a, b) == clamped(a - b * truncated(Fraction(a, b)))


@LAWS
@given(a=WORD, b=WORD)
def test_bit_operations_work_on_32_bits_and_never_warn(a: int, b: int) -> None:
    assert AND(a, b) == (fixed.signed(a & b), [])
    assert OR(a, b) == (fixed.signed(a | b), [])
    assert XOR(a, b) == (fixed.signed(a ^ b), [])
    assert COMPLEMENT(a) == (fixed.signed(~a), [])


@pytest.mark.manual("ARP-082")
def test_shifts_of_a_negative_word_bring_in_zeros() -> None:
    assert RIGHT(-1, 1_000) == (0x7FFF_FFFF, [])
    assert RIGHT(-0x8000_0000, 31_000) == (1, [])
    assert LEFT(-1, 31_000) == (-0x8000_0000, [])
    assert LEFT(0x4000_0001, 1_000) == (-0x7FFF_FFFE, [])


@pytest.mark.manual("ARP-082")
@LAWS
@given(a=WORD, places=st.integers(0, 40))
def test_shifts_bring_in_zeros(a: int, places: int) -> None:
    word = a & 0xFFFF_FFFF
    assert LEFT(a, places * 1000) == (fixed.signed(word << places), [])
    assert RIGHT(a, places * 1000) == (fixed.signed(word >> places), [])


@pytest.mark.long
@LAWS
@given(a=WORD, b=WORD)
def test_words_outside_the_range_are_clamped_by_arithmetic_alone(a: int, b: int) -> None:
    assert ADD(a, b) == clamped(a + b)
    assert MULTIPLY(a, b) == clamped(truncated(Fraction(a * b, 1000)))
    assert DIVIDE(a, b) == (clamped(truncated(Fraction(a * 1000, b))) if b else (0, [201]))
    assert REMAIN(a, b) == (clamped(a - b * truncated(Fraction(a, b))) if b else (0, [201]))


@pytest.mark.manual("ARP-081")
@LAWS
@given(a=RAW)
def test_root_and_whole_part_are_exact(a: int) -> None:
    assert ROOT(a) == ((math.isqrt(a * 1000), []) if a >= 0 else (0, [203]))
    assert WHOLE(a) == (truncated(Fraction(a, 1000)) * 1000, [])


@pytest.mark.manual("ARP-080")
@pytest.mark.parametrize(
    ("expression", "raw"),
    [
        ("2.5 * 1.5", 3_750),
        ("10 / 3", 3_333),
        ("10 \\ 3", 3_333),
        ("10 % 4", 2_000),
        ("H1388", 5_000),
        ("h1000", 4_096),
        ("HFFFFFFFF", -1),
        ("5", 5_000),
        ("1000.000", 1_000_000),
        ("PIG", 3_142),
        ("HI + ON", 2_000),
        ("LO + OFF", 0),
        ("-7 / 2", -3_500),
        ("-10 % 4", -2_000),
        ("2 + 3 * 4", 14_000),
        ("(2 + 3) * 4", 20_000),
        ("10 - 4 - 3", 3_000),
        ("H0F | H30 ^ H10 & HFF", 0x2F),
        ("1 + 1 << 2", 8_000),
        ("H0F << 4", 0xF0),
        ("!H0F", -16),
        ("((1 + 2) / 3) + 4", 5_000),
    ],
)
def test_worked_values(expression: str, raw: int) -> None:
    assert Computed(f"{expression} + 0 * V1" if expression == "5" else expression)(0) == (raw, [])


@pytest.mark.manual("ARP-080")
@pytest.mark.parametrize(
    ("expression", "raw", "swapped"),
    [
        ("H0F & HFF ^ HF0", 0xFF, 0x0F),
        ("HF0 ^ H0F & H0F", 0xFF, 0x0F),
        ("HFF ^ HF0 | HF0", 0xFF, 0x0F),
        ("HF0 | HFF ^ HF0", 0xFF, 0x0F),
        ("H0F & H0F | HF0", 0xFF, 0x0F),
        ("HF0 | H0F & H0F", 0xFF, 0x0F),
        ("HF0 & H0F << 4", 0xF0, 0x00),
        ("HF0 ^ H0F << 4", 0x00, 0xFF0),
        ("1 << 1 + 1", 4_000, 3_000),
        ("8 >> 2 - 1", 4_000, 1_000),
        ("7 - 6 / 2", 4_000, 500),
        ("9 % 4 + 1", 2_000, 4_000),
        ("16 / 4 / 2", 2_000, 8_000),
        ("16 >> 2 >> 1", 2_000, 8_000),
    ],
)
def test_each_operator_binds_as_the_table_has_it(expression: str, raw: int, swapped: int) -> None:
    """`swapped` is the value with the other operator first."""
    assert Computed(f"{expression} + 0 * V1")(0)[1] == []
    assert Computed(expression)(0) == (raw, [])
    assert raw != swapped


@pytest.mark.manual("ARP-081")
@pytest.mark.parametrize(
    ("expression", "raw"),
    [
        ("SQR(2)", 1_414), ("INT(856.56)", 856_000), ("INT(-0.5)", 0), ("SEN(30)", 500), ("SEN(-30)", -500),
        ("COS(60)", 500), ("SEN(90)", 1_000), ("COS(180)", -1_000), ("SEN(360.5)", 9), ("COS(45)", 707),
    ],
)  # fmt: skip
def test_functions(expression: str, raw: int) -> None:
    assert Computed(expression)(0) == (raw, [])


def test_division_by_zero_is_w01_and_gives_0() -> None:
    assert DIVIDE(5_000, 0) == (0, [201])
    assert REMAIN(5_000, 0) == (0, [201])
    assert Computed("V1 / 0")(5_000) == (0, [201])


def test_a_result_out_of_range_is_w02_and_the_limit() -> None:
    assert Computed("999999 * 2")(0) == (999_999_999, [202])
    assert Computed("-999999.999 - 0.001")(0) == (-999_999_999, [202])


def test_each_operation_is_checked_in_brackets_too() -> None:
    assert Computed("(V1 + V1) - V1")(600_000_000) == (399_999_999, [202])


def test_a_negative_shift_count_is_w03() -> None:
    assert LEFT(1_000, -1_000) == (0, [203])


@pytest.mark.parametrize(
    ("raw", "text"), [(0, "0"), (2_500, "2.5"), (-1, "-0.001"), (5_000, "5"), (-999_999_999, "-999999.999")]
)
def test_values_as_a_person_writes_them(raw: int, text: str) -> None:
    assert fixed.to_text(raw) == text
    assert fixed.to_raw(text) == raw


@pytest.mark.parametrize("value", ["0.0001", "1000000", "-1000000"])
def test_values_that_do_not_fit_are_refused(value: str) -> None:
    with pytest.raises(ValueError, match=value):
        fixed.to_raw(value)


@LAWS
@given(degrees=st.integers(-LIMIT, LIMIT))
def test_sine_is_that_of_the_angle_within_its_turn(degrees: int) -> None:
    arithmetic = Arithmetic(print)
    assert arithmetic.sine(degrees) == arithmetic.sine(degrees % 360_000)
    assert arithmetic.sine(degrees) == -arithmetic.sine(-degrees)
    assert arithmetic.cosine(degrees) == arithmetic.sine(degrees + 90_000)
