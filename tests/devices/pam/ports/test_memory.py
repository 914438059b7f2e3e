"""The memory, and the ways to it: bytes, Modbus registers, and words over TCP."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tcp_client import ServedConnection

from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_bus.modbus.server import ModbusServer
from fieldrig_devices.pam.ports.access.faces import MemoryUnit
from fieldrig_devices.pam.ports.access.word_service import serving_words
from fieldrig_devices.pam.ports.memory import ByteOrder, Memory

ORDERS: list[ByteOrder] = ["big", "little"]


@pytest.mark.parametrize(("order", "data"), [("big", "12 34 ab cd"), ("little", "34 12 cd ab")])
def test_byte_orders(order: ByteOrder, data: str) -> None:
    memory = Memory()
    memory.write(10, [0x1234, 0xABCD])
    assert memory.read_bytes(20, 4, order) == bytes.fromhex(data)
    assert memory.read_bytes(21, 2, order) == bytes.fromhex(data)[1:3]


@given(st.sampled_from(ORDERS), st.integers(0, 4096), st.binary(max_size=40))
def test_written_bytes_are_read_and_others_stay(order: ByteOrder, address: int, data: bytes) -> None:
    memory = Memory()
    memory.write(0, [0x5AA5] * 2048)
    expected = bytearray(memory.read_bytes(0, 4096, order))
    if address + len(data) > 4096:
        with pytest.raises(IndexError):
            memory.write_bytes(address, data, order)
    else:
        memory.write_bytes(address, data, order)
        expected[address : address + len(data)] = data
    assert memory.read_bytes(0, 4096, order) == bytes(expected)


class Watched(list[int]):
    """Words that note each write."""

    def __init__(self) -> None:
        super().__init__([0] * 2048)
        self.written: list[tuple[int, int]] = []

    def __setitem__(self, place: object, value: object) -> None:
        assert isinstance(place, int)
        assert isinstance(value, int)
        self.written.append((place, value))
        super().__setitem__(place, value)


def test_a_word_is_written_at_once() -> None:
    words = Watched()
    Memory(words).write_bytes(5, b"\x11\x22\x33\x44", "big")
    assert words.written == [(2, 0x0011), (3, 0x2233), (4, 0x4400)]


@pytest.mark.parametrize(
    ("request_", "response"),
    [
        ("03 00 0a 00 02", "03 04 12 34 ab cd"),
        ("04 00 0a 00 01", "04 02 12 34"),
        ("06 00 0a 00 07", "06 00 0a 00 07"),
        ("10 07 fe 00 02 04 00 01 00 02", "10 07 fe 00 02"),
        ("10 07 ff 00 02 04 00 01 00 02", "90 02"),
        ("03 07 ff 00 02", "83 02"),
        ("01 00 00 00 01", "81 02"),
        ("0f 00 00 00 01 01 01", "8f 02"),
        ("18 00 00", "98 02"),
    ],
)
def test_register_n_is_word_n(request_: str, response: str) -> None:
    memory = Memory()
    memory.write(10, [0x1234, 0xABCD])
    answer = ModbusServer(MemoryUnit(memory)).answer(ModbusRequest(1, bytes.fromhex(request_), 1))
    assert answer == bytes.fromhex(response)
    if request_.startswith("10 07 fe"):
        assert memory.read(0x7FE, 2) == [1, 2]


def test_words_over_tcp() -> None:
    memory = Memory()
    client = ServedConnection(serving_words(memory))
    assert client.send(bytes.fromhex("57 000a 0002 1234 abcd")) == bytes.fromhex("00")
    assert client.send(bytes.fromhex("52 000a 0003")) == bytes.fromhex("00 1234 abcd 0000")
    assert client.send(bytes.fromhex("43 000a 0001 1234 0001")) == bytes.fromhex("00 1234")
    assert client.send(bytes.fromhex("43 000a 0001 1234 0002")) == bytes.fromhex("00 0001")
    assert memory.read(10, 1) == [1]
    assert client.send(bytes.fromhex("52 07ff 0002")) == bytes.fromhex("01")
    assert client.send(bytes.fromhex("57 07ff 0002 0001 0002")) == bytes.fromhex("01")
    assert client.send(bytes.fromhex("52 07ff 0001")) == bytes.fromhex("00 0000")
    assert not client.is_closed
    client.send(b"X")
    assert client.is_closed


@given(st.lists(st.integers(1, 9), min_size=1, max_size=20))
def test_requests_come_in_any_pieces(sizes: list[int]) -> None:
    memory = Memory()
    client = ServedConnection(serving_words(memory))
    data = bytes.fromhex("57 000a 0002 1234 abcd  52 000a 0002  43 000b 0001 abcd 0007  52 000b 0001")
    answer, at = b"", 0
    for size in (*sizes, len(data)):
        answer += client.send(data[at : at + size])
        at = min(at + size, len(data))
    assert answer == bytes.fromhex("00  00 1234 abcd  00 abcd  00 0007")


@given(st.binary(max_size=200))
def test_any_bytes_over_tcp(data: bytes) -> None:
    client = ServedConnection(serving_words(Memory()))
    client.send(data)
    if not client.is_closed:
        client.session.ended()
    assert client.is_closed


def test_a_client_that_takes_no_answers_is_disconnected() -> None:
    client = ServedConnection(serving_words(Memory()), is_taking=False)
    for _ in range(300):
        client.send(bytes.fromhex("52 0000 0800"))
    assert client.is_closed
