from typing import Any

import pytest

from fieldrig_bus.can.frame import CanFrame


@pytest.mark.parametrize(
    "fields",
    [
        {"identifier": 0},
        {"identifier": 0x7FF, "data": bytes(8)},
        {"identifier": 0x1FFF_FFFF, "data": b"\x01", "is_extended": True},
        {"identifier": 0x123, "is_remote": True, "remote_length": 8},
        {"identifier": 0x123, "data": bytes(64), "is_fd": True, "is_bit_rate_switched": True},
        {"identifier": 0x123, "data": bytes(20), "is_fd": True},
    ],
)
def test_a_frame_that_the_standard_knows_is_made(fields: dict[str, Any]) -> None:
    frame = CanFrame(**fields)
    assert {name: getattr(frame, name) for name in fields} == fields


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({"identifier": 0x800}, "identifier 0x800: expected at most 0x7ff, or is_extended=True"),
        ({"identifier": 0x900, "data": b""}, "identifier 0x900: expected at most 0x7ff, or is_extended=True"),
        ({"identifier": -1}, "identifier -0x1: expected at most 0x7ff"),
        ({"identifier": 0x2000_0000, "is_extended": True}, "identifier 0x20000000: expected at most 0x1fffffff"),
        ({"identifier": 1, "data": bytes(9)}, "9 bytes"),
        ({"identifier": 1, "data": bytes(12)}, "12 bytes of data: expected a length .*, or is_fd=True"),
        ({"identifier": 1, "data": bytes(9), "is_fd": True}, "9 bytes"),
        ({"identifier": 1, "data": bytes(65), "is_fd": True}, "65 bytes"),
        ({"identifier": 1, "is_fd": True, "is_remote": True}, "CAN FD has no remote frames"),
        ({"identifier": 1, "is_bit_rate_switched": True}, "only an FD frame"),
        ({"identifier": 1, "data": b"\x00", "is_remote": True}, "has no data"),
        ({"identifier": 1, "is_remote": True, "remote_length": 9}, "0 to 8"),
        ({"identifier": 1, "remote_length": 1}, "and 0 in any other"),
    ],
)
def test_any_other_is_refused_with_the_reason(fields: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        CanFrame(**fields)


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({"identifier": "0x123"}, "identifier: expected int, found str"),
        ({"identifier": True}, "identifier: expected int, found bool"),
        ({"identifier": 1, "data": bytearray(2)}, "data: expected bytes, found bytearray"),
        ({"identifier": 1, "data": [1, 2]}, "data: expected bytes, found list"),
        ({"identifier": 1, "is_extended": 1}, "is_extended: expected bool, found int"),
        ({"identifier": 1, "is_remote": True, "remote_length": "8"}, "remote_length: expected int, found str"),
    ],
)
def test_a_field_of_another_type_is_refused(fields: dict[str, Any], complaint: str) -> None:
    with pytest.raises(TypeError, match=complaint):
        CanFrame(**fields)
