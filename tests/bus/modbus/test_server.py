"""The application protocol, V1.1b3: the answer to any request is well formed, and equals that of a plain model."""

import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, ModbusError
from fieldrig_bus.modbus.message import LineState, ModbusRequest
from fieldrig_bus.modbus.server import ModbusServer

SIZE = 300


class PlainBits:
    def __init__(self) -> None:
        self.values = [False] * SIZE

    def read(self, address: int, quantity: int) -> bytes:
        _check(address, quantity)
        packed = bytearray((quantity + 7) // 8)
        for index, value in enumerate(self.values[address : address + quantity]):
            packed[index // 8] |= value << index % 8
        return bytes(packed)

    def write(self, address: int, quantity: int, packed: bytes) -> None:
        _check(address, quantity)
        for index in range(quantity):
            self.values[address + index] = bool(packed[index // 8] >> index % 8 & 1)


class PlainRegisters:
    def __init__(self) -> None:
        self.values = [0] * SIZE

    def read(self, address: int, quantity: int) -> bytes:
        _check(address, quantity)
        return struct.pack(f">{quantity}H", *self.values[address : address + quantity])

    def write(self, address: int, data: bytes) -> None:
        quantity = len(data) // 2
        _check(address, quantity)
        self.values[address : address + quantity] = struct.unpack(f">{quantity}H", data)


class PlainData:
    def __init__(self) -> None:
        self.coils, self.discrete_inputs = PlainBits(), PlainBits()
        self.holding_registers, self.input_registers = PlainRegisters(), PlainRegisters()

    def fifo(self, address: int) -> list[int]:
        if address >= 40:
            raise ModbusError(ILLEGAL_DATA_ADDRESS)
        return list(range(address))

    def exception_status(self) -> int:
        return 0x6D


def _check(address: int, quantity: int) -> None:
    if address + quantity > SIZE:
        raise ModbusError(ILLEGAL_DATA_ADDRESS)


def answer(server: ModbusServer, request: str, unit: int = 1, line: LineState | None = None) -> str | None:
    response = server.answer(ModbusRequest(unit, bytes.fromhex(request), 0, line))
    return None if response is None else response.hex()


pdus = st.one_of(
    st.binary(min_size=1, max_size=253),
    st.builds(
        lambda code, rest: bytes((code,)) + rest,
        st.sampled_from([1, 2, 3, 4, 5, 6, 7, 8, 15, 16, 17, 22, 23, 24, 43]),
        st.one_of(
            st.binary(max_size=252),
            st.builds(
                lambda address, count, data: struct.pack(">HHB", address, count, len(data)) + data,
                st.integers(0, SIZE),
                st.integers(0, 130),
                st.binary(max_size=247),
            ),
        ),
    ),
)
lines = st.sampled_from([None, LineState(5, 1), LineState(5, 1, True)])


@pytest.mark.long
@settings(max_examples=300, deadline=None)
@given(st.lists(pdus, min_size=1, max_size=5), lines)
def test_every_answer_is_well_formed(requests: list[bytes], line: LineState | None) -> None:
    server = ModbusServer(PlainData())
    for request in requests:
        response = server.answer(ModbusRequest(1, request, 0, line))
        if response is None:
            assert line is not None
            assert server.diagnostics.is_listening_only
            continue
        assert 2 <= len(response) <= 253
        if response[0] == request[0] and request[0] < 0x80:
            assert response[0] < 0x80
        else:
            assert response[0] == request[0] | 0x80
            assert len(response) == 2
            assert 1 <= response[1] <= 4


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.integers(0, SIZE), st.integers(0, 130), st.binary(min_size=260, max_size=260))
def test_what_is_written_is_read(address: int, quantity: int, data: bytes) -> None:
    plain = PlainData()
    server = ModbusServer(plain)
    before = list(plain.holding_registers.values)
    body = data[: 2 * quantity]
    response = server.answer(ModbusRequest(1, struct.pack(">BHHB", 16, address, quantity, len(body) & 0xFF) + body))
    if not 1 <= quantity <= 123:
        assert response == b"\x90\x03"
    elif address + quantity > SIZE:
        assert response == b"\x90\x02"
    else:
        assert response == struct.pack(">BHH", 16, address, quantity)
        read = server.answer(ModbusRequest(1, struct.pack(">BHH", 3, address, quantity)))
        assert read == bytes((3, 2 * quantity)) + body
        return
    assert plain.holding_registers.values == before


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.integers(0, SIZE), st.integers(0, 2100), st.binary(min_size=263, max_size=263))
def test_bits_that_are_written_are_read(address: int, quantity: int, data: bytes) -> None:
    server = ModbusServer(PlainData())
    size = (quantity + 7) // 8
    body = data[:size]
    response = server.answer(ModbusRequest(1, struct.pack(">BHHB", 15, address, quantity, size & 0xFF) + body))
    if not 1 <= quantity <= 1968:
        assert response == b"\x8f\x03"
    elif address + quantity > SIZE:
        assert response == b"\x8f\x02"
    else:
        rest = (1 << quantity) - 1
        wanted = (int.from_bytes(body, "little") & rest).to_bytes(size, "little")
        read = server.answer(ModbusRequest(1, struct.pack(">BHH", 1, address, quantity)))
        assert read == bytes((1, size)) + wanted


@given(st.integers(0, 0xFFFF), st.integers(0, 0xFFFF), st.integers(0, 0xFFFF))
def test_a_mask_takes_bits_from_the_register_or_from_the_or_mask(present: int, and_mask: int, or_mask: int) -> None:
    plain = PlainData()
    plain.holding_registers.values[4] = present
    ModbusServer(plain).answer(ModbusRequest(1, struct.pack(">BHHH", 22, 4, and_mask, or_mask)))
    for bit in range(16):
        source = present if and_mask >> bit & 1 else or_mask
        assert plain.holding_registers.values[4] >> bit & 1 == source >> bit & 1


def test_a_line_counts_what_its_receiver_saw_since_the_restart() -> None:
    server = ModbusServer(PlainData())
    assert answer(server, "08 000B 0000", line=LineState(10, 3)) == "08000b000a"
    assert answer(server, "08 000C 0000", line=LineState(11, 3)) == "08000c0003"
    assert answer(server, "08 0001 0000", line=LineState(12, 3)) == "0800010000"
    assert answer(server, "08 000B 0000", line=LineState(13, 5)) == "08000b0001"
    assert answer(server, "08 000C 0000", line=LineState(14, 5)) == "08000c0002"


def test_a_broadcast_that_fails_counts_as_exception_and_is_not_answered() -> None:
    server, line = ModbusServer(PlainData()), LineState(1)
    assert answer(server, "06 5555 0000", unit=0, line=line) is None
    assert answer(server, "08 000D 0000", line=line) == "08000d0001"
    assert answer(server, "08 000F 0000", line=line) == "08000f0001"


def test_listen_only_mode_ends_with_a_restart_without_an_answer() -> None:
    server, line = ModbusServer(PlainData()), LineState(1)
    assert answer(server, "08 0004 0000", line=line) is None
    assert answer(server, "03 0000 0001", line=line) is None
    assert answer(server, "08 0001 00FF", line=line) is None
    assert answer(server, "03 0000 0001", line=line) is None
    assert answer(server, "08 0001 FF00", line=line) is None
    assert answer(server, "03 0000 0001", line=line) == "03020000"


def test_the_delimiter_can_be_changed_on_ascii_only() -> None:
    server = ModbusServer(PlainData())
    assert answer(server, "08 0003 2100", line=LineState(1, 0, True)) == "0800032100"
    assert answer(server, "08 0003 2101", line=LineState(1, 0, True)) == "8803"
    assert answer(server, "08 0003 8000", line=LineState(1, 0, True)) == "8803"
    assert answer(server, "08 0003 2100", line=LineState(1)) == "8801"


def test_functions_of_serial_lines_can_be_left_out_on_tcp() -> None:
    server = ModbusServer(PlainData(), serial_functions_on_tcp=False)
    for function in ("07", "08 0000 A537", "11"):
        assert answer(server, function) == f"{int(function[:2], 16) | 0x80:02x}01"
    assert answer(server, "07", line=LineState(1)) == "076d"
