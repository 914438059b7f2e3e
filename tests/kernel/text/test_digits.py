"""Values as people read them."""

import struct

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fieldrig.text.digits import show_value, show_with_unit, with_fewer_digits


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (229.89999389648438, "V", "229.9"),  # 229.9 as a REAL
        (229.9, "V", "229.9"),
        (2299 * 0.1, "V", "229.9"),  # 229.9 as a register of 0.1 V
        (3 * 0.1, "", "0.3"),
        (0.5037289472123, "m", "0.503729"),
        (0.0008, "m3/s", "0.0008"),
        (0.00012345678912, "m3/s", "0.0001234568"),
        (1 / 3, "", "0.3333333"),
        (1234567.891, "", "1234568"),
        (123456789.25, "", "123456789"),
        (0.0, "V", "0"),
        (-0.0000001, "V", "0"),
        (3.0, "V", "3"),
        (1e300, "", "1e+300"),
        (1.5e-9, "", "1.5e-09"),
        (-17.25, "degC", "-17.25"),
        (float("inf"), "", "inf"),
        (12, "V", "12"),
        (True, "", "true"),
        ("red", "", "red"),
    ],
)
def test_a_value_has_the_digits_that_its_type_and_unit_bear(value: float | str, unit: str, text: str) -> None:
    assert show_value(value, unit) == text


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_a_value_of_32_bits_is_read_back_as_the_same_bits(value: float) -> None:
    assert struct.pack("<f", float(show_value(value))) == struct.pack("<f", value + 0.0)


@given(st.floats(allow_nan=False, allow_infinity=False))
@example(1.401298464324817e-45)  # the smallest of 32 bits, which has one digit there
def test_any_value_keeps_seven_digits_or_its_32_bits(value: float) -> None:
    shown = float(show_value(value))
    assert shown == pytest.approx(value, rel=1e-6, abs=0) or struct.pack("<f", shown) == struct.pack("<f", value)


@given(st.floats(-1e15, 1e15), st.sampled_from(["V", "m", "rpm", ""]))
def test_no_text_is_long(value: float, unit: str) -> None:
    assert len(show_value(value, unit).lstrip("-").replace(".", "").lstrip("0").partition("e")[0]) <= 17


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("tank.level = 0.5037289472123 m, 0.00012345678912 m/s", "tank.level = 0.503729 m, 0.000123 m/s"),
        ("p = 12.333333333333334 Hz, 3 pulses", "p = 12.33333 Hz, 3 pulses"),
        ("705 [1] 05", "705 [1] 05"),
        ("peer 127.0.0.1:5020 V1.25", "peer 127.0.0.1:5020 V1.25"),
        ("a = 0.5", "a = 0.5"),
        ("version = 1.20, in 1 ms", "version = 1.20, in 1 ms"),
        ("version = 2.0, in 1 ms", "version = 2.0, in 1 ms"),
        ("TIME 2022-01-27 00:30:07.000", "TIME 2022-01-27 00:30:07.000"),
        ("speed 2.0 m/s", "speed 2 m/s"),
    ],
)
def test_messages_are_shown_with_fewer_digits(text: str, shown: str) -> None:
    assert with_fewer_digits(text) == shown


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (4000, "0.1 %", "4000 x 0.1 %"),
        (8230, "10ms", "8230 x 10ms"),
        (229.89999389648438, "V", "229.9 V"),
        (7, "", "7"),
        (True, "", "true"),
        ("", "", ""),
    ],
)
def test_a_unit_with_a_number_is_a_factor(value: object, unit: str, text: str) -> None:
    """It read `4000 0.1 %`, as if there were two values."""
    assert show_with_unit(value, unit) == text


def test_a_text_of_a_device_moves_no_cursor() -> None:
    """It went to the terminal as it was, with the colours and the bell that were in it."""
    text = "1\tbooted\n2\t\x1b[31mred\x07\x00\u202eend"
    assert show_value(text) == "1\tbooted\n2\t\\x1b[31mred\\x07\\x00\\u202eend"
