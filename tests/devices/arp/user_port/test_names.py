"""Frames of the USER port in words: the data are those of the tables in docs/devices/arp/arp-user-port.md."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.arp.user_port.framing import encode
from fieldrig_devices.arp.user_port.names import UserPortReader

ANSWER = 0x80


def frame(command: int, data: str = "", sequence: int = 1) -> bytes:
    return encode(bytes((1, 1, sequence, command)) + bytes.fromhex(data))


@pytest.mark.parametrize(
    ("command", "data", "kind", "text"),
    [
        (0x10, "46 0300 0200", "READ", "F3 to F4"),
        (0x11, "56 0100 50 0200", "READ_MANY", "V1, @POS2"),
        (0x13, "4f 6500 0200 01", "WRITE_BITS", "O101 = 1, O102 = 0"),
        (0x20, "01 00 05 01", "READ_PARAMETERS", "flash @PAR[5]"),
        (0x21, "00 01 07 e8030000", "WRITE_PARAMETER", "RAM @PAR1[7] = 1"),
        (0x30, "10000000 efbeadde", "DOWNLOAD_BEGIN", "16 octets, CRC DEADBEEFh"),
        (0x31, "f0000000 0102", "DOWNLOAD_BLOCK", "2 octets at 240"),
        (0x40, "04000000", "BREAKPOINTS_SET", "lines 4"),
        (0x50, "01", "EVENTS", "on"),
        (0x51, "0200 56 0100", "TRACE_START", "every 2 loops V1"),
        (0xE0, "03 02 0000 00 0000 04000000 00", "EVENT", "RUN, program running, line 4"),
        (0xE0, "05 05 7400 02 0000 00000000 00", "EVENT", "BLOCKED, program failed, ERROR 116 of axis 2"),
        (0xE1, "02000000 0000", "SAMPLES", "2 octets of samples, 2 lost"),
        (0xE2, "03000000 0a000000 6c696e6573", "PROGRESS", "3 of 10 lines"),
        (0x10, "ff 0100 0100", "READ", "FF 01 00 01 00"),
        (0x5F, "01", "command 5Fh", "01"),
    ],
)
def test_a_frame_has_its_command_and_its_values(command: int, data: str, kind: str, text: str) -> None:
    assert UserPortReader()("pc", frame(command, data)) == [(kind, f"card 01: {text}")]


@pytest.mark.parametrize(
    ("command", "asked", "answered", "text"),
    [
        (0x10, "46 0300 0200", "00 02", "F3 = 0, F4 = 1"),
        (0x11, "56 0100 46 0100", "00 c4090000 01000000", "V1 = 2.5, F1 = 1"),
        (0x20, "00 00 05 01", "00 e8030000", "RAM @PAR[5] = 1"),
        (0x34, "", "00 10000000 efbeadde", "16 octets, CRC DEADBEEFh"),
        (0x41, "", "00 04000000 09000000", "lines 4, 9"),
        (0x03, "", "05 456e61626c65", "REFUSED Enable"),
        (0x03, "", "63", "status 99"),
    ],
)
def test_an_answer_is_named_by_its_request(command: int, asked: str, answered: str, text: str) -> None:
    reader = UserPortReader()
    reader("pc", frame(command, asked))
    ((kind, told),) = reader("card", frame(command | ANSWER, answered))
    assert kind.endswith(" answer")
    assert told == f"card 01: {text}"


def test_an_answer_without_its_request_is_shown_in_hex() -> None:
    assert UserPortReader()("card", frame(0x90, "00 c4")) == [("READ answer", "card 01: C4")]


@given(command=st.integers(0, 255), data=st.binary(max_size=30), asked=st.binary(max_size=12))
def test_any_frame_has_some_words(command: int, data: bytes, asked: bytes) -> None:
    reader = UserPortReader()
    for sent in (frame(command & 0x7F, asked.hex()), frame(command, data.hex())):
        ((kind, text),) = reader("pc", sent)
        assert kind
        assert text.startswith(("card", "any card"))
