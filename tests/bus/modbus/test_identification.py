"""Read device identification: Modbus application protocol V1.1b3, 6.21."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from pymodbus.pdu.mei_message import ReadDeviceInformationResponse

from fieldrig_bus.modbus.identification import LONGEST_OBJECT, Identification, ServerId

BASIC = {"vendor_name": "V", "product_code": "P", "revision": "R"}


def ask(identification: Identification, code: int, first: int) -> ReadDeviceInformationResponse:
    """The objects in an answer as pymodbus decodes it."""
    pdu = identification.answer(bytes((0x2B, 0x0E, code, first)))
    assert len(pdu) <= 253
    response = ReadDeviceInformationResponse()
    response.decode(pdu[1:])
    return response


@pytest.mark.parametrize(
    ("more", "level"),
    [({}, 0x81), ({"product_name": "N"}, 0x82), ({"extended": {0x80: "X"}}, 0x83)],
)
def test_the_conformity_level_says_what_there_is(more: dict[str, object], level: int) -> None:
    assert ask(Identification.model_validate(BASIC | more), 1, 0).conformity == level


@pytest.mark.parametrize(
    ("code", "numbers"), [(1, [0, 1, 2]), (2, [0, 1, 2, 4]), (3, [0, 1, 2, 4, 0x80, 0xFF]), (4, [0])]
)
def test_a_code_asks_for_a_category(code: int, numbers: list[int]) -> None:
    identification = Identification.model_validate(
        BASIC | {"product_name": "N", "extended": {0xFF: "last", 0x80: "first"}}
    )
    assert list(ask(identification, code, 0).information) == numbers


texts = st.text("abc ", max_size=LONGEST_OBJECT)


@settings(max_examples=50, deadline=None)
@given(st.dictionaries(st.integers(0x80, 0xFF), texts, max_size=12), texts)
def test_more_follows_until_everything_was_sent(extended: dict[int, str], name: str) -> None:
    identification = Identification(vendor_name=name, product_code="P", revision="R", extended=extended)
    found: dict[int, bytes] = {}
    first = 0
    while True:
        response = ask(identification, 3, first)
        found.update(response.information)
        if response.more_follows != 0xFF:
            break
        first = response.next_object_id
    assert {number: bytes(text) for number, text in found.items()} == identification.objects()
    assert response.next_object_id == 0


@pytest.mark.parametrize("wrong", [{"vendor_name": "ü"}, {"product_code": 245 * "x"}, {"extended": {0x7F: "x"}}])
def test_what_the_objects_can_not_say_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        Identification.model_validate(wrong)


def test_the_server_id_is_followed_by_the_run_indicator() -> None:
    assert ServerId(server_id="0815", is_running=False, additional="x").data() == bytes.fromhex("0815 00") + b"x"
    with pytest.raises(ValidationError):
        ServerId(server_id="081")
