"""Messages as bytes, for other processes and traces."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.modbus.codec import decode, encode, show
from fieldrig_bus.modbus.message import (
    Asked,
    ClientConnected,
    DamagedAnswer,
    LineState,
    ModbusEvent,
    ModbusRequest,
    ModbusResponse,
    OnModbus,
)

units, pdus, numbers = st.integers(0, 255), st.binary(min_size=1, max_size=253), st.integers(0, 0xFFFF_FFFF)
line_states = st.one_of(st.none(), st.builds(LineState, numbers, numbers, st.booleans()))
messages = st.one_of(
    st.builds(ModbusRequest, units, pdus, numbers, line_states),
    st.builds(ModbusResponse, units, pdus, numbers, st.none() | st.builds(Asked, units, numbers)),
    st.builds(ClientConnected, st.ip_addresses().map(str)),
)


@given(messages)
def test_what_is_encoded_is_decoded(message: ModbusEvent) -> None:
    again = decode(encode(message))
    assert again == message
    if isinstance(message, ModbusResponse):
        assert isinstance(again, ModbusResponse)
        assert again.asked == message.asked


@pytest.mark.parametrize(
    ("message", "data"),
    [
        (ModbusRequest(0x11, b"\x03\x00\x6b\x00\x03", 0x1234), "01 11 34120000 03006b0003"),
        (ModbusResponse(0x11, b"\x83\x02", 1), "00 11 01000000 8302"),
        (ModbusResponse(0xFF, b"\x83\x02", 1, Asked(0x11, 7)), "06 ff 01000000 11 07000000 8302"),
        (DamagedAnswer(1, b"\x07", 2, ((3, b"\x09"),), True), "05 01 02000000 01 01 07 0300000000000000 0100 09"),
        (DamagedAnswer(1, b"\x07", 2, asked=Asked(3, 4)), "05 01 02000000 02 01 03 04000000 07"),
        (ModbusRequest(1, b"\x07", 1, LineState(2, 3)), "02 01 01000000 02000000 03000000 07"),
        (ModbusRequest(1, b"\x07", 1, LineState(2, 3, True)), "03 01 01000000 02000000 03000000 07"),
        (ClientConnected("10.0.0.9"), "04 00 00000000 31302e302e302e39"),
    ],
)
def test_bytes_are_as_written_down(message: OnModbus, data: str) -> None:
    assert encode(message) == bytes.fromhex(data)
    assert decode(bytes.fromhex(data)) == message


@given(st.binary(max_size=300) | st.binary(max_size=12).map(lambda data: b"\x04\0\0\0\0\0" + data))
def test_other_bytes_are_no_message(data: bytes) -> None:
    try:
        message = decode(data)
    except ValueError:
        return
    assert encode(message) == data


def test_a_person_reads_function_and_exception() -> None:
    assert show(ModbusRequest(1, bytes.fromhex("03006b0003"))) == "unit 1 ask read holding registers  03 00 6b 00 03"
    assert show(ModbusResponse(1, b"\x83\x02")) == "unit 1 answer read holding registers: illegal data address  83 02"
    assert show(ClientConnected("10.0.0.9")) == "connection from 10.0.0.9"
    assert show(ModbusResponse(1, b"\xe5")) == "unit 1 answer function 101: exception 0  e5"
