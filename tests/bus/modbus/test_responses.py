"""Responses that match a request: Modbus application protocol V1.1b3, chapter 6, with its own examples."""

import modbus_cases
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.modbus.line_client import fits

EXAMPLES = [
    *(step for case in modbus_cases.EXAMPLES for step in case.steps),
    ("2B 0E 01 00", "2B 0E 01 01 00 00 01 00 02 4142"),  # 6.21, shortened
]
ODD = [
    ("03 006B 0003", "04 06 022B 0000 0064"),  # another function
    ("03 006B 0003", "03 04 022B 0000"),  # too few registers
    ("03 006B 0003", "03 06 022B 0000"),  # less than its byte count
    ("03 006B 0003", "03 06 022B 0000 0064 00"),  # more than its byte count
    ("03 006B 0003", "03"),
    ("01 0013 0013", "01 02 CD6B"),
    ("06 0001 0003", "06 0001 0004"),  # another value
    ("10 0001 0002 04 000A 0102", "10 0001 0001"),
    ("10 0001 0002 04 000A 0102", "10 0001 0002 00"),
    ("0F 0013 000A 02 CD01", "0F 0014 000A"),
    ("17 0003 0006 000E 0003 06 00FF 00FF 00FF", "17 06 00FE 0ACD 0001"),
    ("03 006B 0003", "84 02"),  # an exception of another function
    ("03 006B 0003", "83"),
    ("03 006B 0003", "83 02 00"),
]


@pytest.mark.parametrize(("request_", "response"), EXAMPLES)
def test_the_examples_of_the_specification_fit(request_: str, response: str) -> None:
    assert fits(bytes.fromhex(request_), bytes.fromhex(response))


@pytest.mark.parametrize("request_", [request for request, _ in EXAMPLES])
def test_an_exception_fits_its_function(request_: str) -> None:
    request = bytes.fromhex(request_)
    assert fits(request, bytes((request[0] | 0x80, 2)))


@pytest.mark.parametrize(("request_", "response"), ODD)
def test_others_do_not_fit(request_: str, response: str) -> None:
    assert not fits(bytes.fromhex(request_), bytes.fromhex(response))


pdus = st.binary(min_size=1, max_size=253)


@given(pdus, pdus)
def test_any_pair_is_judged(request: bytes, response: bytes) -> None:
    if fits(request, response):
        assert response[0] & 0x7F == request[0] & 0x7F
