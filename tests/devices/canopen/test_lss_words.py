"""LSS messages in words; the bytes are those of the protocols in CiA 305."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.canopen.lss_words import SERVICES, lss_words

REQUESTS = [
    ("04 00 00 00 00 00 00 00", "switch state global waiting"),
    ("40 B2 01 00 00 00 00 00", "select vendor-ID 000001B2h"),
    ("43 78 56 34 12 00 00 00", "select serial number 12345678h"),
    ("48 01 00 00 00 00 00 00", "identify revision number from 00000001h"),
    ("4C 00 00 00 00 00 00 00", "identify non-configured"),
    ("51 00 00 00 00 80 00 00", "fastscan of all non-configured"),
    ("51 00 00 01 00 1F 00 00", "fastscan vendor-ID 00010000h from bit 31"),
    ("51 B2 01 00 00 00 00 01", "fastscan vendor-ID 000001B2h from bit 0, then product code"),
    ("11 20 00 00 00 00 00 00", "configure node-ID 32"),
    ("11 FF 00 00 00 00 00 00", "configure node-ID none"),
    ("13 00 03 00 00 00 00 00", "configure bit timing 250 kbit/s"),
    ("13 80 01 00 00 00 00 00", "configure bit timing entry 1 of table 128"),
    ("15 F4 01 00 00 00 00 00", "activate bit timing in 500 ms"),
    ("17 00 00 00 00 00 00 00", "store configuration"),
    ("5E 00 00 00 00 00 00 00", "inquire node-ID"),
    ("15 F4 01", "activate bit timing F4 01"),
    ("7F 01 00 00 00 00 00 00", "service 127 01 00 00 00 00 00 00"),
]
ANSWERS = [
    ("44 00 00 00 00 00 00 00", "selected"),
    ("4F 00 00 00 00 00 00 00", "identify slave"),
    ("11 00 00 00 00 00 00 00", "configure node-ID done"),
    ("11 01 00 00 00 00 00 00", "configure node-ID node-ID out of range"),
    ("13 01 00 00 00 00 00 00", "configure bit timing bit rate not supported"),
    ("17 02 00 00 00 00 00 00", "store configuration not stored"),
    ("17 FF 05 00 00 00 00 00", "store configuration error 5 of the maker"),
    ("5A B2 01 00 00 00 00 00", "inquire vendor-ID 000001B2h"),
    ("5E 05 00 00 00 00 00 00", "inquire node-ID 5"),
]


@pytest.mark.parametrize(
    ("sent", "words", "is_request"), [(*each, True) for each in REQUESTS] + [(*each, False) for each in ANSWERS]
)
def test_services_say_what_they_carry(sent: str, words: str, is_request: bool) -> None:
    assert lss_words(bytes.fromhex(sent), is_request=is_request) == words


@given(st.one_of(st.just(b""), st.sampled_from(sorted(SERVICES)).map(lambda code: bytes((code,)))),
       st.binary(max_size=7), st.booleans())  # fmt: skip
def test_any_bytes_have_words(service: bytes, rest: bytes, is_request: bool) -> None:
    assert lss_words(service + rest, is_request=is_request).isprintable()
