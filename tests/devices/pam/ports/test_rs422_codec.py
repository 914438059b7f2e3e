"""The framing of the project's RS422 protocol, as docs/devices/pam/pam-ports.md describes it."""

import struct
from binascii import crc_hqx
from itertools import chain

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.pam.ports.rs422.codec import FramedCodec, LineFault
from fieldrig_devices.pam.ports.rs422.messages import FIELDS, Code, Message

REQUEST = bytes.fromhex("02 01 f1 d1 03")  # CRC-16/CCITT-FALSE of 01 is F1D1


def message_of(code: Code, data: bytes) -> Message:
    return Message(code, FIELDS[code].unpack(data))


def messages_of(code: Code) -> st.SearchStrategy[Message]:
    size = FIELDS[code].size
    return st.binary(min_size=size, max_size=size).map(lambda data: message_of(code, data))


messages = (
    st.sampled_from(Code).flatmap(messages_of).filter(lambda found: all(value == value for value in found.values))
)
"""Messages without NaN, which equals nothing."""


def test_frames() -> None:
    codec = FramedCodec()
    assert codec.encode(Message(Code.REQUEST)) == REQUEST
    assert list(codec.decode(REQUEST)) == [Message(Code.REQUEST)]
    escaped = codec.encode(Message(Code.DEF_OUT, (0x0210, 0x0300_0001)))
    assert escaped[:10] == bytes.fromhex("02 10 23 10 22 10 30 10 23 00")


@given(st.lists(messages, max_size=5), st.integers(1, 7))
def test_messages_arrive_in_any_pieces(sent: list[Message], size: int) -> None:
    codec = FramedCodec()
    data = b"".join(map(codec.encode, sent))
    pieces = [data[at : at + size] for at in range(0, len(data), size)]
    assert list(chain.from_iterable(map(codec.decode, pieces))) == sent


@given(st.binary(max_size=300))
def test_any_bytes_are_decoded(data: bytes) -> None:
    codec = FramedCodec()
    for found in codec.decode(data):
        assert isinstance(found, Message | LineFault)
    assert list(codec.decode(REQUEST))[-1] == Message(Code.REQUEST)


@given(messages, st.data())
def test_a_wrong_byte_never_makes_another_message(message: Message, data: st.DataObject) -> None:
    frame = bytearray(FramedCodec().encode(message))
    place = data.draw(st.integers(0, len(frame) - 1))
    frame[place] ^= 1 << data.draw(st.integers(0, 7))
    assert all(not isinstance(found, Message) or found == message for found in FramedCodec().decode(bytes(frame)))


@pytest.mark.parametrize(
    ("data", "found"),
    [
        ("02 01 f1 d2 03", [LineFault.CRC]),
        ("02 01 03", [LineFault.CRC]),
        ("02 01 f1 02 01 f1 d1 03", [LineFault.END_CHARACTER, Message(Code.REQUEST)]),
        ("01 f1 d1 03 02 01 f1 d1 03", [LineFault.START_CHARACTER, Message(Code.REQUEST)]),
        ("02" + "00" * 65 + "03", [LineFault.END_CHARACTER]),
    ],
)
def test_faults(data: str, found: list[object]) -> None:
    assert list(FramedCodec().decode(bytes.fromhex(data))) == found


def test_unknown_codes_and_wrong_lengths_are_no_commands() -> None:
    for content, code in ((b"\x77", 0x77), (b"\x01\x00", 0), (b"\x05" + struct.pack(">H", 4), 0)):
        frame = b"\x02" + content + crc_hqx(content, 0xFFFF).to_bytes(2, "big") + b"\x03"
        (message,) = FramedCodec().decode(frame)
        assert isinstance(message, Message)
        assert message.code == code
