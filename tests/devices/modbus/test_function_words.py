"""Functions without registers in words: the examples of Modbus application protocol V1.1b3, chapter 6."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.modbus.codec import EXCEPTIONS, FUNCTIONS
from fieldrig_devices.modbus.function_words import request_of, response_of

IDENTIFIED = (
    "2B 0E 01 01 00 00 03 00 16" + b"Company identification".hex() + "01 0F" + b"Product code XX".hex()
    + "02 05" + b"V2.11".hex()
)  # fmt: skip


@pytest.mark.parametrize(
    ("pdu", "words"),
    [
        ("07", ""),
        ("08 00 00 A5 37", "return query data A537h"),
        ("08 00 01 FF 00", "restart communications FF00h"),
        ("08 00 0B 00 00", "bus message count"),
        ("0B", ""),
        ("11", ""),
        ("14 0E 06 00 04 00 01 00 02 06 00 03 00 09 00 02", "file 4 records 1-2, file 3 records 9-10"),
        ("15 0D 06 00 04 00 07 00 03 06 AF 04 BE 10 0D", "file 4 records 7-9 = 06AFh 04BEh 100Dh"),
        ("18 04 DE", "1246"),
        ("2B 0E 01 00", "device identification, basic"),
        ("2B 0E 02 03", "device identification, regular from VendorUrl"),
        ("2B 0E 04 81", "device identification, one object from object 81h"),
        ("2B 0D 00 01", "0D 00 01"),
        ("14 07 07 00 04 00 01 00 02", "07 07 00 04 00 01 00 02"),
        ("14 0E 06 00 04", "0E 06 00 04"),
        ("14 00", "nothing"),
        ("08 00 63 00 00", "00 63 00 00"),
        ("41 01 02", "01 02"),
    ],
)
def test_requests(pdu: str, words: str) -> None:
    """Another reference type or interface, a length that lies, a function of a maker: in hexadecimal."""
    assert request_of(bytes.fromhex(pdu)) == words


@pytest.mark.parametrize(
    ("pdu", "words"),
    [
        ("07 6D", "6Dh"),
        ("08 00 00 A5 37", "A537h"),
        ("08 00 0B 01 08", "264"),
        ("0B FF FF 01 08", "busy, 264 events"),
        ("0C 08 00 00 01 08 01 21 20 00", "ready, 264 events, 289 messages, the last events 20 00"),
        ("11 05 41 42 43 31 FF", '"ABC1", 41 42 43 31 FF'),
        ("11 02 07 FF", "07 FF"),
        ("14 0C 05 06 0D FE 00 20 05 06 33 CD 00 40", "0DFEh 0020h, 33CDh 0040h"),
        ("15 0D 06 00 04 00 07 00 03 06 AF 04 BE 10 0D", "file 4 records 7-9 = 06AFh 04BEh 100Dh"),
        ("18 00 06 00 02 01 B8 12 84", "01B8h 1284h"),
        (IDENTIFIED, 'VendorName "Company identification", ProductCode "Product code XX", Revision "V2.11"'),
        ("2B 0E 03 83 FF 80 01 04 01 1B", "ProductName 1B, more from object 80h"),
        ("0C 08 00 00", "08 00 00"),
        ("11 05 41", "05 41"),
        ("14 0C 05 06 0D", "0C 05 06 0D"),
        ("18 00 06 00 03 01 B8 12 84", "00 06 00 03 01 B8 12 84"),
        ("2B 0E 01 01 00 00 03 00 16 43", "0E 01 01 00 00 03 00 16 43"),
    ],
)
def test_responses(pdu: str, words: str) -> None:
    assert response_of(bytes.fromhex(pdu)) == words


@given(st.sampled_from([7, 8, 11, 12, 17, 20, 21, 24, 43]), st.binary(max_size=260))
def test_any_bytes_have_words_that_can_be_printed(function: int, data: bytes) -> None:
    pdu = bytes((function,)) + data
    assert all(words.isprintable() for words in (request_of(pdu), response_of(pdu)))


def test_every_function_and_exception_of_the_standard_has_a_name() -> None:
    """Public functions of 5.1, and exceptions of chapter 7."""
    assert FUNCTIONS.keys() >= {*range(1, 9), 11, 12, 15, 16, 17, 20, 21, 22, 23, 24, 43}
    assert EXCEPTIONS.keys() >= {1, 2, 3, 4, 5, 6, 8, 10, 11}
