"""Characters received in another format than they were sent in.  Expected values were derived by hand, bit by bit."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.serial.garble import garbled
from fieldrig_bus.serial.message import Format

BAUD = 1200

DRAWN = [
    # 0x00 at half the rate: start and data low for 9 bit times, 18 of the receiver's; the first frame takes 9.5 of
    # them and finds its stop bit low, so it waits for the next falling edge, which never comes.
    (b"\x00", Format(BAUD), Format(2 * BAUD), b"\x00"),
    # 0xff at twice the receiver's rate: only the start bit is low, for half of the receiver's start bit.
    (b"\xff", Format(2 * BAUD), Format(BAUD), b"\xff"),
    # 0x55 is 0 10101010 1 on the line, so at twice the rate 00 11 00 11 00 11 00 11 00 11 and then idle:
    # start 0, data 0 11 00 11 0, stop 0 (wrong); next edge at the 13th: start 0, data 0 11 00 11 1, stop 1
    (b"\x55", Format(BAUD), Format(2 * BAUD), bytes.fromhex("66 e6")),
    # even parity read without: the parity bit of 0x03 is 0 and stands where the stop bit is looked for
    (b"\x03", Format(BAUD, 8, "E"), Format(BAUD), b"\x03"),
    # 7 data bits and even parity read as 8 data bits: the parity bit becomes bit 7
    (b"\x07A", Format(BAUD, 7, "E"), Format(BAUD), b"\x87A"),
]


@pytest.mark.parametrize(("data", "sent_as", "received_as", "heard"), DRAWN)
def test_line_is_sampled_at_the_receivers_rate(data: bytes, sent_as: Format, received_as: Format, heard: bytes) -> None:
    assert garbled(data, sent_as, received_as) == heard


@given(st.binary(max_size=40), st.integers(1, 10**7), st.sampled_from("NEO"), st.sampled_from([1, 2]))
def test_same_format_loses_nothing(data: bytes, baud: int, parity: str, stop_bits: int) -> None:
    form = Format(baud, 8, parity, stop_bits)  # type: ignore[arg-type]  # sampled from the literals
    assert garbled(data, form, form) == data


@given(st.binary(max_size=40), st.integers(-20, 20))
def test_two_percent_off_is_still_understood(data: bytes, per_mille: int) -> None:
    assert garbled(data, Format(100_000), Format(100_000 + 100 * per_mille)) == data


@given(st.binary(max_size=20), st.integers(1, 10**6), st.integers(1, 10**6), st.sampled_from([5, 6, 7, 8]))
def test_any_two_formats_give_some_bytes(data: bytes, baud: int, other: int, data_bits: int) -> None:
    if other / baud < 100:
        garbled(data, Format(baud), Format(other, data_bits))  # type: ignore[arg-type]  # sampled from the literals
