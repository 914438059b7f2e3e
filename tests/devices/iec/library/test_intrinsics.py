"""The standard functions: the manual's results, the choice of an implementation, and properties."""

import math
from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from library_bench import Bench

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library import fixed, intrinsics
from fieldrig_devices.iec.library.arguments import Argument, Untyped, common, widens
from fieldrig_devices.iec.library.conversions import convert
from fieldrig_devices.iec.library.intrinsics import (
    IMPLEMENTATIONS,
    OPERATORS,
    evaluate,
    find,
    formal_names,
    is_standard,
)
from fieldrig_devices.iec.library.overload import Overload, expand
from fieldrig_devices.iec.library.reals import single
from fieldrig_devices.iec.library.timed import TIMED
from fieldrig_devices.iec.types import (
    ArrayType,
    BlockType,
    EnumType,
    Field,
    ObjectType,
    PointerType,
    StringType,
    StructType,
    SubrangeType,
    Type,
    Value,
)

N = Untyped
E = Elementary
TEXT = StringType()
BITS = [E.BYTE, E.WORD, E.DWORD, E.LWORD]
INTEGERS = [kind for kind in E if kind.is_integer]


def overload(name: str, arguments: Sequence[Argument], wanted: Type | None = None) -> Overload:
    found = find(name, arguments, wanted)
    assert isinstance(found, Overload), found
    return found


def call(name: str, *arguments: tuple[Argument, Value] | int | float, wanted: Type | None = None) -> Value:
    """Call a function like the compiled program does: convert the arguments, then run its Python."""
    pairs = [argument if isinstance(argument, tuple) else (N(argument), argument) for argument in arguments]
    found = overload(name, [kind for kind, _ in pairs], wanted)
    given = [_converted(kind, value, into) for (kind, value), into in zip(pairs, found.parameters, strict=True)]
    return evaluate(found.name, given)


def _converted(kind: Argument, value: Value, into: Type) -> Value:
    if isinstance(kind, Untyped):
        return float(value) if into in (E.REAL, E.LREAL) else value
    return convert(value, kind, into)


def real(value: float) -> tuple[E, float]:
    return E.REAL, single(value)


def text(value: str) -> tuple[StringType, str]:
    return TEXT, value


# PacDrive manual 2227 to 2396 and 2747 to 2813 (PD-L30 to PD-L33, PD-L44, PD-L45).
MANUAL = [
    (call("SHL", 1, 1), 2),
    (call("SHR", 32, 2), 8),
    (call("ROL", (E.BYTE, 0b1001_0011), 3), 0b1001_1100),
    (call("ROR", (E.BYTE, 0b1001_0011), 3), 0b0111_0010),
    (call("SEL", (E.BOOL, True), 3, 4), 4),
    (call("SEL", (E.BOOL, False), 3, 4), 3),
    (call("MAX", 90, 30, 40, 77), 90),
    (call("MIN", 90, 30, 40, 77), 30),
    (call("LIMIT", 30, 90, 80), 80),
    (call("LIMIT", 90, 30, 80), 80),
    (call("MUX", 0, 30, 40, 50, 60, 70, 80), 30),
    (call("TRUNC", 1.9), 1),
    (call("TRUNC", -1.4), -1),
    (call("EXPT", 7, 2), 49),
    (call("ABS", -2), 2),
]


@pytest.mark.manual("PD-386")
@pytest.mark.parametrize(("result", "expected"), MANUAL)
def test_examples_of_the_manual(result: Value, expected: Value) -> None:
    assert result == expected


# Shifts: by the width or more; of signed integers; rotations go round the width.
SHIFTS = [
    ("SHL", E.BYTE, 0xFF, 7, 0x80),
    ("SHL", E.BYTE, 0xFF, 8, 0),
    ("SHL", E.WORD, 1, 1_000_000, 0),
    ("SHL", E.INT, 1, 15, -32_768),
    ("SHR", E.WORD, 0x8000, 15, 1),
    ("SHR", E.WORD, 0x8000, 16, 0),
    ("SHR", E.DWORD, 0xFFFF_FFFF, 4_000_000_000, 0),
    ("SHR", E.INT, -4, 1, -2),
    ("SHR", E.INT, -4, 99, -1),
    ("ROL", E.WORD, 0x8001, 1, 0x0003),
    ("ROL", E.WORD, 0x8001, 17, 0x0003),
    ("ROL", E.DWORD, 0x1234_5678, 8, 0x3456_7812),
    ("ROR", E.DWORD, 0x1234_5678, 8, 0x7812_3456),
    ("ROR", E.BYTE, 0x01, 8, 0x01),
    ("ROL", E.INT, -32_768, 1, 1),
    ("ROR", E.INT, 1, 1, -32_768),
]


@pytest.mark.parametrize(("name", "kind", "value", "count", "result"), SHIFTS)
def test_shifts_are_as_wide_as_their_operand(name: str, kind: E, value: int, count: int, result: int) -> None:
    assert call(name, (kind, value), (E.DWORD, count)) == result


@given(st.data())
def test_rotation_moves_every_bit(data: st.DataObject) -> None:
    kind = data.draw(st.sampled_from(BITS))
    value = data.draw(st.integers(0, kind.high))
    count = data.draw(st.integers(0, 200))
    bits = f"{value:0{kind.bits}b}"
    turn = count % kind.bits
    assert call("ROL", (kind, value), (E.DWORD, count)) == int(bits[turn:] + bits[:turn], 2)
    assert call("ROR", (kind, call("ROL", (kind, value), (E.DWORD, count))), (E.DWORD, count)) == value


def test_a_shifted_literal_is_as_wide_as_what_is_wanted() -> None:
    assert overload("SHL", [N(1), N(10)], E.WORD).result is E.WORD
    assert overload("SHL", [N(1), N(10)]).result is E.BYTE
    assert overload("SHL", [N(300), N(10)]).result is E.WORD
    assert overload("SHR", [N(-1), N(10)]).result is E.SINT


@pytest.mark.parametrize(
    ("base", "exponent", "result"),
    [(2, 10, 1024), (-3, 3, -27), (0, 0, 1), (2, -1, 0), (-1, -3, -1), (1, -5, 1), (0, -1, 0)],
)
def test_powers_of_integers(base: int, exponent: int, result: int) -> None:
    assert call("EXPT", (E.DINT, base), (E.DINT, exponent)) == result


def test_powers_of_integers_wrap_around_in_their_type() -> None:
    assert call("EXPT", (E.INT, 3), (E.INT, 11)) == (3**11 + 2**15) % 2**16 - 2**15
    assert call("EXPT", (E.DINT, 10), (E.DINT, 2_000_000_000)) == 0  # a multiple of 2 ** 32


NAN, INF = math.nan, math.inf
IEEE = [
    ("SQRT", -1.0, NAN), ("SQRT", INF, INF), ("LN", 0.0, -INF), ("LN", -1.0, NAN), ("LN", INF, INF), ("LOG", 0.0, -INF),
    ("EXP", 100.0, INF), ("EXP", -200.0, 0.0), ("SIN", INF, NAN), ("COS", -INF, NAN), ("TAN", NAN, NAN),
    ("ASIN", 2.0, NAN), ("ACOS", -1.5, NAN), ("SQRT", NAN, NAN),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value", "result"), IEEE)
def test_real_functions_give_the_results_of_ieee_754(name: str, value: float, result: float) -> None:
    got = call(name, (E.REAL, value))
    assert got == result or (math.isnan(result) and isinstance(got, float) and math.isnan(got))


@pytest.mark.parametrize(
    ("base", "exponent", "result"),
    [(10.0, 39.0, INF), (-10.0, 39.0, -INF), (0.0, -1.0, INF), (-0.0, -1.0, -INF), (0.0, -2.0, INF), (1e300, 2.0, INF)],
)
def test_powers_of_real_numbers_are_those_of_c(base: float, exponent: float, result: float) -> None:
    kind = E.LREAL if abs(base) > 1e38 else E.REAL
    assert call("EXPT", (kind, base), (kind, exponent)) == result


def test_real_results_are_rounded_to_single_precision() -> None:
    assert call("SQRT", real(2.0)) == single(math.sqrt(2.0)) != math.sqrt(2.0)
    assert call("SQRT", (E.LREAL, 2.0)) == math.sqrt(2.0)
    assert call("EXPT", real(0.1), real(2.0)) == single(single(0.1) ** 2)


@given(st.floats(), st.sampled_from(sorted(intrinsics.REAL_FUNCTIONS)))
def test_real_functions_never_raise(value: float, name: str) -> None:
    assert isinstance(evaluate(f"{name}.REAL", [value]), float)
    assert isinstance(evaluate(f"{name}.LREAL", [value]), float)


@given(st.floats(), st.floats())
def test_powers_never_raise(base: float, exponent: float) -> None:
    assert isinstance(evaluate("EXPT.LREAL", [base, exponent]), float)


@pytest.mark.long
@settings(max_examples=300)
@given(st.data())
def test_integer_functions_stay_in_range(data: st.DataObject) -> None:
    kind = data.draw(st.sampled_from(INTEGERS))
    value = data.draw(st.integers(kind.low, kind.high))
    other = data.draw(st.integers(kind.low, kind.high))
    count = data.draw(st.integers(0, 2**32 - 1))
    results = [call(name, (kind, value), (E.DWORD, count)) for name in ("SHL", "SHR", "ROL", "ROR")]
    results += [call("ABS", (kind, value)), call("EXPT", (kind, value), (kind, other))]
    results += [call("TRUNC", (E.LREAL, data.draw(st.floats())), wanted=kind)]
    assert all(type(result) is int and kind.low <= result <= kind.high for result in results)


def test_the_smallest_integer_has_no_absolute_value() -> None:
    assert call("ABS", (E.INT, -32_768)) == -32_768
    assert call("ABS", (E.DINT, -32_768)) == 32_768


def test_truncation_goes_to_int_unless_more_is_wanted() -> None:
    assert overload("TRUNC", [E.REAL]).result is E.INT
    assert call("TRUNC", real(100_000.0)) == 100_000 - 131_072
    assert call("TRUNC", real(100_000.0), wanted=E.DINT) == 100_000
    assert call("TRUNC", (E.LREAL, -1.999_999_999_9)) == -1


# ---- selection of the types


def test_arguments_meet_in_the_largest_type() -> None:
    assert overload("MAX", [E.INT, E.DINT, E.BYTE]).result is E.DINT
    assert overload("MAX", [E.INT, E.WORD]).result is E.INT
    assert overload("MAX", [E.INT, E.REAL]).result is E.REAL
    assert overload("MAX", [E.INT, N(40_000)]).result is E.DINT
    assert overload("MAX", [E.INT, N(0.5)]).result is E.REAL
    assert overload("MAX", [E.TIME, E.TIME]).result is E.TIME
    assert overload("MAX", [N(1), N(2)], E.LREAL).result is E.LREAL
    assert overload("MAX", [StringType(10), StringType(20)]).result == StringType(20)


def test_selections_take_every_type() -> None:
    color = EnumType("color", {"red": 0, "green": 1})
    assert overload("SEL", [E.BOOL, color, color]).result is color
    assert overload("SEL", [E.BOOL, color, E.DINT]).result is E.DINT
    assert overload("MUX", [E.USINT, TEXT, TEXT]).result == TEXT
    assert overload("MOVE", [E.DT]).result is E.DT
    assert overload("MOVE", [SubrangeType(E.INT, 0, 5)]).result == SubrangeType(E.INT, 0, 5)


def test_the_last_value_answers_for_a_number_that_is_too_large() -> None:
    assert call("MUX", 5, 10, 20, 30) == 30
    assert call("MUX", (E.INT, -1), (E.INT, 10), (E.INT, 20)) == 20


def test_real_functions_take_integers() -> None:
    assert overload("SQRT", [E.INT]).parameters == (E.REAL,)
    assert overload("SQRT", [N(2)]).result is E.REAL
    assert overload("SQRT", [N(2)], E.LREAL).result is E.LREAL
    assert overload("EXPT", [E.REAL, E.INT]).result is E.REAL
    assert overload("EXPT", [N(7), N(2)], E.INT).result is E.INT
    assert call("EXPT", 10, 6, wanted=E.REAL) == 1_000_000


WRONG: list[tuple[str, list[Argument], str]] = [
    ("ABS", [TEXT], "ABS: expected one number, got STRING"),
    ("SIN", [], "SIN: expected one number, got nothing"),
    ("SEL", [E.INT, E.INT, E.INT], "SEL: expected a BOOL and two values, got INT, INT, INT"),
    ("MAX", [E.TIME, E.INT], "MAX: expected at least two values of the same kind, got TIME, INT"),
    ("MUX", [E.REAL, E.INT], "MUX: expected an integer and the values, got REAL, INT"),
    ("SHL", [E.REAL, E.INT], "SHL: expected a bit string or integer and the number of bits, got REAL, INT"),
    ("LEN", [E.INT], "LEN: expected STRING(255), got INT"),
    ("LEFT", [TEXT, E.DINT], "LEFT: expected STRING(255), INT, got STRING, DINT"),
    ("INT_TO_REAL", [E.DINT], "INT_TO_REAL: expected one INT, got DINT"),
    ("TRUNC", [E.BOOL], "TRUNC: expected one real number, got BOOL"),
    ("INT_TO_BCD", [E.DINT], "INT_TO_BCD: expected one INT, got DINT"),
    ("FROBNICATE", [], "FROBNICATE is no standard function"),
]


PAIR = StructType("Pair", {"a": Field("a", E.INT)}, 2)


@pytest.mark.parametrize("name", ["SEL", "MUX", "MAX"])
def test_structures_are_not_selected(name: str) -> None:
    found = find(name, [E.BOOL if name == "SEL" else E.INT, PAIR, PAIR])
    assert isinstance(found, str)
    assert found.endswith("Pair, Pair")


def test_structures_are_moved() -> None:
    assert overload("MOVE", [PAIR]).result is PAIR


def test_absolute_value_may_be_outside_the_subrange_of_its_argument() -> None:
    assert overload("ABS", [SubrangeType(E.INT, -5, 3)]).result is E.INT


@pytest.mark.parametrize(("name", "arguments", "message"), WRONG)
def test_message_says_what_was_expected(name: str, arguments: list[Argument], message: str) -> None:
    assert find(name, arguments) == message


def test_conversion_by_name_takes_smaller_types() -> None:
    assert overload("INT_TO_REAL", [E.BYTE]).parameters == (E.INT,)
    assert overload("REAL_TO_INT", [N(1.5)]).result is E.INT
    assert overload("time_of_day_to_string", [E.TOD]).name == "TOD_TO_STRING"


def test_every_name_is_known_in_any_case_of_letters() -> None:
    names = ["abs", "Limit", "add", "GT", "NOT", "int_to_real", "BCD_TO_INT", "WORD_TO_BCD", "CONCAT", "TIME", "Trunc"]
    assert all(map(is_standard, names))
    assert not any(map(is_standard, ["NEG", "TON", "BCD_TO_REAL", "BCD_TO_BCD", "FOO", ""]))
    assert set(OPERATORS) >= {
        "ADD",
        "SUB",
        "MUL",
        "DIV",
        "MOD",
        "AND",
        "OR",
        "XOR",
        "NOT",
        "GT",
        "GE",
        "EQ",
        "NE",
        "LE",
        "LT",
    }


def test_formal_names_are_those_of_the_standard_and_of_codesys() -> None:
    assert formal_names("LIMIT", 3) == ("MN", "IN", "MX")
    assert formal_names("mux", 3) == ("K", "IN0", "IN1")
    assert formal_names("MID", 3) == ("STR", "LEN", "POS")
    assert formal_names("REPLACE", 4) == ("STR1", "STR2", "L", "P")
    assert formal_names("CONCAT", 3) == ("IN1", "IN2", "IN3")
    assert formal_names("SIN", 1) == ("IN",)


# ---- BCD, bits, times


@pytest.mark.parametrize(
    ("name", "kind", "value", "result"),
    [
        ("BCD_TO_INT", E.BYTE, 0x49, 49),
        ("BCD_TO_INT", E.WORD, 0x1234, 1234),
        ("BCD_TO_DINT", E.DWORD, 0x9999_9999, 99_999_999),
        ("BCD_TO_INT", E.BYTE, 0x4A, -1),
        ("INT_TO_BCD", E.INT, 1234, 0x1234),
        ("USINT_TO_BCD", E.USINT, 99, 0x99),
        ("USINT_TO_BCD", E.USINT, 100, 0xFF),
        ("INT_TO_BCD", E.INT, -1, 0xFFFF),
    ],
)
def test_bcd(name: str, kind: E, value: int, result: int) -> None:
    assert call(name, (kind, value)) == result


@given(st.integers(0, 9999))
def test_bcd_there_and_back(value: int) -> None:
    packed = call("INT_TO_BCD", (E.INT, value))
    assert f"{packed:x}" == str(value)
    assert call("BCD_TO_INT", (E.WORD, packed)) == value


@pytest.mark.manual("PD-210")
@given(st.integers(0, 2**32 - 1), st.integers(0, 255), st.booleans())
def test_single_bits(value: int, number: int, is_set: bool) -> None:
    bits = [bit == "1" for bit in reversed(f"{value:032b}")]
    assert call("EXTRACT", (E.DWORD, value), (E.BYTE, number)) is (bits[number] if number < 32 else False)
    if number < 32:
        bits[number] = is_set
    expected = int("".join("1" if bit else "0" for bit in reversed(bits)), 2)
    assert call("PUTBIT", (E.DWORD, value), (E.BYTE, number), (E.BOOL, is_set)) == expected


def test_pack_puts_the_first_bit_lowest() -> None:
    assert (
        call("PACK", *[(E.BOOL, bit) for bit in (True, False, True, False, False, False, False, True)]) == 0b1000_0101
    )


def test_a_date_and_a_time_of_day_are_one_moment() -> None:
    assert call("CONCAT_DATE_TOD", (E.DATE, 887_328_000), (E.TOD, 51_600_000)) == 887_379_600
    assert call("CONCAT_DATE_LTOD", (E.DATE, 887_328_000), (E.LTOD, 1)) == 887_328_000_000_000_001


@pytest.mark.parametrize("kind", INTEGERS)
def test_bytes_in_another_order_are_those_of_the_value_from_behind(kind: E) -> None:
    for value in (kind.low, kind.high, 1, 0x12 if kind.size == 1 else 0x1234):
        order = value.to_bytes(kind.size, "little", signed=kind.is_signed)
        expected = int.from_bytes(order, "big", signed=kind.is_signed)
        assert call("TO_BIG_ENDIAN", (kind, value)) == expected
        assert call("FROM_BIG_ENDIAN", (kind, expected)) == value
        assert call("TO_LITTLE_ENDIAN", (kind, value)) == value


@pytest.mark.parametrize("kind", BITS)
def test_bcd_of_every_size(kind: E) -> None:
    digits = "9876543210123456"[: kind.size * 2]
    value, integer = int(digits, 16), {1: "USINT", 2: "UINT", 4: "UDINT", 8: "ULINT"}[kind.size]
    assert call(f"{kind}_BCD_TO_{integer}", (kind, value)) == int(digits)
    assert call(f"BCD_TO_{integer}", (kind, value)) == int(digits)
    assert call(f"{integer}_TO_BCD_{kind}", (getattr(E, integer), int(digits))) == value
    assert call("IS_VALID_BCD", (kind, value)) is True
    assert call("IS_VALID_BCD", (kind, value - 1 | 0xA)) is False


# ---- the Python


def test_every_implementation_names_only_what_is_listed_and_uses_each_argument_once() -> None:
    names = [*fixed.FIXED, *intrinsics.REAL_FUNCTIONS, *intrinsics.SHIFTS, "MAX", "MOVE", "ABS", "EXPT", "SEL", "MUX"]
    names += ["MIN", "LIMIT", "TRUNC", "INT_TO_BCD", "BCD_TO_WORD", "DT_TO_STRING", "REAL_TO_INT"]
    found = [
        overload for name in names for types in _arguments(name) if isinstance(overload := find(name, types), Overload)
    ]
    assert {overload.name.partition(".")[0] for overload in found} >= {*fixed.FIXED, "SHL", "TRUNC", "TO_BCD", "BCD_TO"}
    for overload in found:
        _check_python(overload)


def _arguments(name: str) -> list[list[Argument]]:
    if name in fixed.FIXED:
        return [list(fixed.FIXED[name].parameters)]
    kinds = [E.BOOL, *INTEGERS, E.REAL, E.LREAL, E.TIME, E.DT]
    return [list(types) for kind in kinds for types in ((kind,), (kind, kind), (E.BOOL, kind, kind))]


def test_functions_that_are_another_form_of_an_operator() -> None:
    assert TIMED["DIV_TIME"][0] is OPERATORS["DIV"]
    assert {operator.name for operator in OPERATORS.values()} >= intrinsics.BINARY_ONLY


def test_overloaded_conversions_of_edition_3() -> None:
    assert call("TO_INT", (E.LREAL, 2.7)) == 3
    assert call("TO_STRING", (E.INT, 5)) == "5"
    assert call("TO_TIME", text("T#5s")) == 5_000
    assert call("TRUNC_DINT", (E.REAL, -70_000.5)) == -70_000
    assert overload("TO_INT", [E.INT]).name == "MOVE"
    assert overload("TO_REAL", [N(3)]).parameters == (E.INT,)
    assert find("TO_INT", [E.INT, E.INT]) == "TO_INT: expected one value of an elementary type, got INT, INT"
    assert is_standard("to_word")
    assert not is_standard("TRUNC_REAL")


def _check_python(found: Overload) -> None:
    names = [f"a{number}" for number in range(len(found.parameters))]
    text = expand(found.python, names)
    code = compile(text, "", "eval")
    assert set(code.co_names) <= {*names, *IMPLEMENTATIONS, "now_ms"}
    assert all(text.count(name) == 1 for name in names), found
    assert intrinsics.implementation(found.name).python == found.python
    assert found.cost_ns >= 0


def test_arguments_are_put_into_brackets() -> None:
    assert expand("{0} * {1}", ["a + b", "c"]) == "(a + b) * c"
    assert expand("MAX({*})", ["a", "b", "{0}"]) == "MAX(a, b, ({0}))"


# ---- types in common


def test_values_never_go_into_a_smaller_type_by_themselves() -> None:
    assert widens(E.INT, E.DINT)
    assert widens(E.INT, E.WORD)
    assert not widens(E.DINT, E.WORD)
    assert not widens(E.INT, E.BYTE)
    assert not widens(E.BOOL, E.REAL)
    assert not widens(E.REAL, E.DINT)
    assert not widens(E.LREAL, E.REAL)
    assert not widens(N(300), E.BYTE)
    assert not widens(N(1.5), E.INT)
    assert not widens(E.TIME, E.DWORD)


@given(st.lists(st.sampled_from([*E, TEXT]), min_size=1, max_size=4))
def test_every_argument_widens_to_the_type_in_common(kinds: list[E | StringType]) -> None:
    found = common(kinds)
    assert found is None or all(widens(kind, found) for kind in kinds)
    assert found == common(kinds[::-1])


EVERY_TYPE: list[Argument] = [
    *E, TEXT, StringType(255), PAIR, EnumType("color", {"red": 0}), SubrangeType(E.INT, -5, 3), ArrayType(0, 3, E.INT),
    PointerType(E.INT), BlockType("TON"), ObjectType("MC_4"), *map(N, (0, -1, 300, 70_000, 2**40, 1.5, 2**70)),
]  # fmt: skip
EVERY_NAME = sorted(
    {
        *fixed.FIXED,
        *intrinsics.REAL_FUNCTIONS,
        *intrinsics.SHIFTS,
        "ABS",
        "EXPT",
        "SEL",
        "MUX",
        "MOVE",
        "MAX",
        "LIMIT",
        "TRUNC",
    }
    | {
        "INT_TO_BCD",
        "BCD_TO_DINT",
        "REAL_TO_INT",
        "STRING_TO_DT",
        "TO_STRING",
        "TO_INT",
        "TRUNC_DINT",
        "DT_TO_TOD",
        "BOGUS",
    }
)


@pytest.mark.long
@settings(max_examples=1_000)
@given(
    st.sampled_from(EVERY_NAME),
    st.lists(st.sampled_from(EVERY_TYPE), max_size=4),
    st.none() | st.sampled_from([E.INT, E.LREAL, E.TIME, E.WORD, TEXT]),
)
def test_every_call_has_an_answer(name: str, arguments: list[Argument], wanted: Type | None) -> None:
    found = find(name, arguments, wanted)
    if isinstance(found, str):
        assert found.startswith(name)
    else:
        assert len(found.parameters) == len(arguments)
        _check_python(found)


def test_structures_are_copied_by_move_in_a_program() -> None:
    bench = Bench(
        "TYPE Pair : STRUCT a, b : INT; END_STRUCT; END_TYPE\nPROGRAM PLC_PRG\n"
        "VAR x : Pair; y : Pair := (a := 3, b := 4); END_VAR\nx := MOVE(y);\nEND_PROGRAM\n"
    )
    bench.call(0)
    assert bench.read("PLC_PRG.x.b") == 4
