"""Frames of the ring as bytes."""

from dataclasses import fields
from typing import Any, get_args, get_type_hints

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.pamring import codec
from fieldrig_devices.pamring.frames import (
    AxisOrder,
    InputChanged,
    InputItem,
    Motor,
    MotorOrder,
    MotorReport,
    Move,
    Order,
    Report,
    SetOutput,
    SetPoint,
    SetPointMode,
    Severity,
    Trouble,
)

BITS = {"B": 8, "H": 16, "I": 32}
LAYOUTS = {row.form: row.layout for row in (*codec.ORDERS, *codec.REPORTS)}
I64 = st.integers(-(1 << 63), (1 << 63) - 1)
OWN: dict[Any, st.SearchStrategy[Any]] = {
    "MotorOrder": st.builds(
        MotorOrder,
        st.integers(0, 0xFFFF),
        st.sampled_from(Motor),
        st.lists(I64, max_size=3).map(tuple),
        st.integers(0, 0xFFFF_FFFF),
    ),
    "Trouble": st.builds(
        Trouble,
        st.sampled_from(Severity),
        st.integers(0, 0xFFF),
        st.tuples(st.integers(0, 0xFFFF_FFFF), st.integers(0, 0xFFFF_FFFF)),
        st.integers(0, 0xFFFF_FFFF),
    ),
    "SetPoint": st.builds(SetPoint, st.sampled_from(SetPointMode), I64),
}


def values(form: type[Any]) -> st.SearchStrategy[Any]:
    """Any frame of this class, with values that its layout has room for."""
    if form.__name__ in OWN:
        return OWN[form.__name__]
    hints = get_type_hints(form)
    layout = LAYOUTS.get(form, "Iq")  # an Answer, whose value may also be None
    made = [_value(hints[each.name], letter) for each, letter in zip(fields(form), layout, strict=True)]
    return st.builds(form, *made)


def _value(hint: Any, letter: str) -> st.SearchStrategy[Any]:
    if hint is bool:
        return st.booleans()
    if hint == int | None:
        return st.none() | I64
    if hint is not int:
        return st.sampled_from(hint)
    return I64 if letter == "q" else st.integers(0, (1 << BITS[letter]) - 1)


@given(st.one_of([values(form) for form in get_args(Order)]))
def test_every_order_comes_back(order: Order) -> None:
    assert codec.decode_order(codec.encode(order)) == order


@given(st.one_of([values(form) for form in get_args(Report)]))
def test_every_report_comes_back(report: Report) -> None:
    assert codec.decode_report(codec.encode(report)) == report


@given(st.binary(max_size=60))
def test_hostile_bytes_are_a_frame_or_a_value_error(data: bytes) -> None:
    for decode in (codec.decode_order, codec.decode_report, codec.split):
        try:
            decode(data)
        except ValueError:
            continue


@given(st.lists(st.binary(max_size=255), max_size=8))
def test_the_reports_of_a_cycle_come_back_one_by_one(reports: list[bytes]) -> None:
    assert codec.split(codec.join(reports)) == reports


# The bytes are those of the table in docs/devices/pam/pam-ring.md.
@pytest.mark.parametrize(
    ("frame", "expected"),
    [
        (SetPoint(SetPointMode.POSITION, -2), "09 01 feffffffffffffff"),
        (InputItem(3, 201, 1, True, 5, 2), "10 0300 c900 01 01 05000000 02000000"),
        (
            AxisOrder(7, Move.RELATIVE_MOVE, 1 << 32, 2, 3, 4),
            "08 07000000 04 0000000001000000 0200000000000000 0300000000000000 0400000000000000",
        ),
        (MotorOrder(9, Motor.RUN, (-1,), 258), "07 0900 03 02010000 ffffffffffffffff"),
        (SetOutput(6, -1, 5), "04 0600 ffffffffffffffff 05000000"),
        (InputChanged(6, 1, 300, 5), "85 0600 0100000000000000 2c010000 05000000"),
        (MotorReport(9, True, 0x2000, 258), "88 0900 01 00200000 02010000"),
        (Trouble(Severity.WARNING, 0x00E, (0x10002, 5), 0x10), "89 01 0e00 02000100 05000000 10000000"),
    ],
)
def test_frames_look_as_the_page_says(frame: Order | Report, expected: str) -> None:
    assert codec.encode(frame) == bytes.fromhex(expected)


@pytest.mark.parametrize("data", ["", "00", "0104", "09 01 00", "09 04 0000000000000000", "07 0900 63", "ff"])
def test_what_is_no_order_is_refused(data: str) -> None:
    with pytest.raises(ValueError, match=r"not an order|not a valid"):
        codec.decode_order(bytes.fromhex(data))
