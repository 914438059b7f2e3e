"""The four orders of a number in registers, and the two of a text."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.registers.form import FORMATS, ByteOrder, Form, WordOrder

ORDERS: list[tuple[WordOrder, ByteOrder]] = [("big", "big"), ("little", "big"), ("big", "little"), ("little", "little")]


@pytest.mark.parametrize(
    ("type", "number", "bytes_by_order"),
    [
        ("u16", 0xAABB, ("aabb", "aabb", "bbaa", "bbaa")),
        ("s16", -2, ("fffe", "fffe", "feff", "feff")),
        ("u32", 0xAABBCCDD, ("aabbccdd", "ccddaabb", "bbaaddcc", "ddccbbaa")),
        ("f32", 100.0, ("42c80000", "000042c8", "c8420000", "0000c842")),  # IEEE 754: 42C80000h
        ("u64", 0x1122334455667788, ("1122334455667788", "7788556633441122", "2211443366558877", "8877665544332211")),
        ("bcd16", 1979, ("1979", "1979", "7919", "7919")),
        ("bcd32", 12345678, ("12345678", "56781234", "34127856", "78563412")),
    ],
)
def test_a_number_in_each_order(type: str, number: float, bytes_by_order: tuple[str, ...]) -> None:
    forms = [Form(type, *order) for order in ORDERS]
    assert [form.pack(number).hex() for form in forms] == list(bytes_by_order)
    assert [form.unpack(bytes.fromhex(data)) for form, data in zip(forms, bytes_by_order, strict=True)] == [number] * 4


@pytest.mark.parametrize(("type", "number"), [("bcd16", 10_000), ("bcd16", -1), ("bcd32", 10**8)])
def test_a_number_with_too_many_digits_has_no_bcd(type: str, number: int) -> None:
    with pytest.raises(OverflowError):
        Form(type).pack(number)


def test_a_text_and_a_truth_have_the_order_of_the_bytes_only() -> None:
    assert Form("string[5]", "little").pack_text(b"fan 7") == b"fan 7\x00"
    assert Form("string[5]", "big", "little").pack_text(b"fan 7") == b"af n\x007"
    assert Form("string[5]", "big", "little").unpack_text(b"af n\x007") == "fan 7"
    assert Form("bool", "little", "little").pack_truth(True) == b"\x01\x00"


@given(st.sampled_from(sorted(FORMATS)), st.sampled_from(ORDERS), st.binary(min_size=8, max_size=8))
def test_each_order_has_the_same_bytes(type: str, order: tuple[WordOrder, ByteOrder], data: bytes) -> None:
    form, plain = Form(type, *order), Form(type)
    raw = data[: 2 * form.words]
    assert sorted(form._ordered(raw)) == sorted(raw)
    assert form._ordered(form._ordered(raw)) == raw
    number = plain.unpack(raw)
    if plain.low <= number <= plain.high:  # no NaN, and no digit above 9
        assert form.unpack(form.pack(number)) == number
