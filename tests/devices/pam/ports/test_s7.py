"""The data block of S7 clients: the requests are those of snap7 3.3, the answers follow its parser."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tcp_client import ServedConnection

from fieldrig_devices.pam.ports.access.s7 import serving_s7
from fieldrig_devices.pam.ports.memory import Memory

CONNECT = bytes.fromhex("03 00 00 16 11 e0 00 00 00 01 00 c1 02 01 00 c2 02 01 02 c0 01 0a")
CLASS_1 = "03 00 00 0b 06 e0 00 00 00 01 10"
CONFIRM = bytes.fromhex("03 00 00 16 11 d0 00 01 00 01 00 c0 01 0a c1 02 01 00 c2 02 01 02")


class Client:
    def __init__(self) -> None:
        self.memory = Memory()
        self.connection = ServedConnection(serving_s7(self.memory, 1, "big"))
        assert self.connection.send(CONNECT) == CONFIRM

    def ask(self, request: str) -> str:
        """Send a PDU, and return the answer without the headers of the transport."""
        pdu = bytes.fromhex(request)
        answer = self.connection.send(b"\3\0" + (len(pdu) + 7).to_bytes(2, "big") + b"\2\xf0\x80" + pdu)
        assert answer[:2] + answer[4:7] == b"\3\0\2\xf0\x80"
        assert int.from_bytes(answer[2:4], "big") == len(answer)
        return answer[7:].hex(" ")


@pytest.fixture
def client() -> Client:
    return Client()


def test_set_up(client: Client) -> None:
    answer = client.ask("32 01 00 00 00 01 00 08 00 00 f0 00 00 01 00 01 01 e0")
    assert answer == "32 03 00 00 00 01 00 08 00 00 00 00 f0 00 00 01 00 01 01 e0"


def test_a_read_of_bytes(client: Client) -> None:
    client.memory.write(22, [7, 0x20, 0x169F, 0x27AD])
    answer = client.ask("32 01 00 00 00 02 00 0e 00 00 04 01 12 0a 10 02 00 0e 00 01 84 00 01 60")
    assert answer == ("32 03 00 00 00 02 00 02 00 12 00 00 04 01 ff 04 00 70 00 07 00 20 16 9f 27 ad 00 00 00 00 00 00")


def test_a_write_of_bytes_words_and_bits(client: Client) -> None:
    client.memory.write(0x82, [0xFFFF, 0xFFFF])
    answer = client.ask("32 01 00 00 00 03 00 0e 00 06 05 01 12 0a 10 02 00 02 00 01 84 00 08 28 00 04 00 10 08 01")
    assert answer == "32 03 00 00 00 03 00 02 00 01 00 00 05 01 ff"
    assert client.memory.read(0x82, 2) == [0xFF08, 0x01FF]  # bytes 105h and 106h
    client.ask("32 01 00 00 00 04 00 0e 00 06 05 01 12 0a 10 04 00 01 00 01 84 00 00 b0 00 04 00 10 12 34")
    assert client.memory.read(11, 1) == [0x1234]
    client.ask("32 01 00 00 00 06 00 0e 00 05 05 01 12 0a 10 01 00 01 00 01 84 00 08 29 00 03 00 01 01")
    assert client.memory.read(0x82, 1) == [0xFF0A]  # bit 1 of byte 105h
    answer = client.ask("32 01 00 00 00 05 00 0e 00 00 04 01 12 0a 10 01 00 01 00 01 84 00 08 2b")
    assert answer == "32 03 00 00 00 05 00 02 00 05 00 00 04 01 ff 03 00 01 01"


def test_several_items_begin_at_even_bytes(client: Client) -> None:
    client.memory.write(0, [0xAB00, 0x1234])
    answer = client.ask(
        "32 01 00 00 00 07 00 26 00 00 04 03 12 0a 10 02 00 01 00 01 84 00 00 00"
        "12 0a 10 02 00 02 00 01 84 00 00 10 12 0a 10 02 00 02 00 09 84 00 00 10"
    )
    assert answer == ("32 03 00 00 00 07 00 02 00 10 00 00 04 03 ff 04 00 08 ab 00 ff 04 00 10 12 34 0a 00 00 00")


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        ("04 01 12 0a 10 02 00 02 00 01 84 00 7f f8", "04 01 05 00 00 00"),  # byte 4095 and one more
        ("04 01 12 0a 10 02 00 02 00 00 83 00 00 00", "04 01 0a 00 00 00"),  # a flag of the controller
        ("04 01 12 0a 10 02 00 02 00 01 84 00 00 01", "04 01 05 00 00 00"),  # bytes from a bit on
        ("04 01 12 0a 10 02 00 00 00 01 84 00 00 00", "04 01 05 00 00 00"),  # no bytes
        ("04 01 12 0a 10 1c 00 01 00 01 84 00 00 00", "04 01 06 00 00 00"),  # a counter
    ],
)
def test_items_that_do_not_exist(client: Client, request_: str, answer: str) -> None:
    parameters = bytes.fromhex(request_)
    found = client.ask(f"32 01 00 00 00 01 00 {len(parameters):02x} 00 00 {request_}")
    assert found == f"32 03 00 00 00 01 00 02 00 04 00 00 {answer}"


def test_other_functions_are_refused(client: Client) -> None:
    szl = "32 07 00 00 00 08 00 08 00 08 00 01 12 04 11 44 01 00 ff 09 00 04 00 1c 00 00"
    assert client.ask(szl) == "32 03 00 00 00 08 00 00 00 00 81 04"
    assert client.ask("32 01 00 00 00 09 00 01 00 00 29") == "32 03 00 00 00 09 00 00 00 00 81 04"
    large = client.ask("32 01 00 00 00 02 00 0e 00 00 04 01 12 0a 10 02 02 00 00 01 84 00 00 00")
    assert large == "32 03 00 00 00 02 00 00 00 00 85 00"


def test_a_message_in_two_packets(client: Client) -> None:
    pdu = bytes.fromhex("32 01 00 00 00 01 00 08 00 00 f0 00 00 01 00 01 01 e0")
    first = b"\3\0\0\x0b\2\xf0\0" + pdu[:4]
    assert client.connection.send(first) == b""
    assert client.connection.send(b"\3\0" + (len(pdu) + 3).to_bytes(2, "big") + b"\2\xf0\x80" + pdu[4:])


def test_an_answer_is_cut_to_the_size_of_the_client() -> None:
    connection = ServedConnection(serving_s7(Memory(), 1, "big"))
    connection.send(bytes.fromhex("03 00 00 0e 09 e0 00 00 00 01 00 c0 01 07"))  # TPDUs of 128 bytes
    read = "03 00 00 1f 02 f0 80 32 01 00 00 00 02 00 0e 00 00 04 01 12 0a 10 02 00 c8 00 01 84 00 00 00"
    answer = connection.send(bytes.fromhex(read))  # 200 bytes
    assert answer[:7] == bytes.fromhex("03 00 00 84 02 f0 00")
    assert answer[132:139] == bytes.fromhex("03 00 00 64 02 f0 80")
    assert len(answer) == 132 + 0x64


def test_a_connection_with_an_endless_message_is_closed(client: Client) -> None:
    for _ in range(9):
        assert not client.connection.is_closed
        client.connection.send(b"\3\0\4\7\2\xf0\0" + bytes(1024))
    assert client.connection.is_closed


@pytest.mark.parametrize("packet", ["05 00 00 07", "03 00 00 05", "03 00 ff ff", "03 00 00 07 02 f0 80", CLASS_1])
def test_what_is_no_connection_is_closed(packet: str) -> None:
    connection = ServedConnection(serving_s7(Memory(), 1, "big"))
    connection.send(bytes.fromhex(packet))
    assert connection.is_closed


@given(st.binary(max_size=60), st.booleans())
def test_any_bytes_are_survived(data: bytes, is_connected: bool) -> None:
    client = Client()
    sent = b""
    if is_connected:
        for pdu in (data, b"\x32\1\0\0\0\1" + len(data).to_bytes(2, "big") + b"\0\0" + data):
            sent += client.connection.send(b"\3\0" + (len(pdu) + 7).to_bytes(2, "big") + b"\2\xf0\x80" + pdu)
    sent += client.connection.send(data)
    while sent:  # everything that was sent is whole packets
        length = int.from_bytes(sent[2:4], "big")
        assert sent[:2] == b"\3\0"
        assert len(sent) >= length > 7
        sent = sent[length:]


@given(st.binary(min_size=12, max_size=12), st.sampled_from([4, 5]), st.binary(max_size=12))
def test_any_address_is_answered(address: bytes, function: int, data: bytes) -> None:
    parameters = bytes((function, 1)) + b"\x12\x0a\x10" + address[3:]
    pdu = b"\x32\1\0\0\0\1" + len(parameters).to_bytes(2, "big") + len(data).to_bytes(2, "big") + parameters + data
    assert Client().ask(pdu.hex()).startswith("32 03 00 00 00 01")
