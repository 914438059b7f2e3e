"""Separation of Telnet commands and data (RFC 854), and negotiation of options (RFC 1143)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.serial.telnet import (
    BINARY,
    DO,
    DONT,
    LONGEST_COMMAND,
    WILL,
    WONT,
    Event,
    Negotiation,
    Options,
    Subnegotiation,
    TelnetReader,
    escape,
    subnegotiation,
)


def read(*pieces: bytes) -> list[Event]:
    """Events, with consecutive pieces of data joined."""
    reader = TelnetReader()
    events: list[Event] = []
    for event in (event for piece in pieces for event in reader.feed(piece)):
        if isinstance(event, bytes) and events and isinstance(events[-1], bytes):
            events[-1] += event
        elif event:
            events.append(event)
    return events


# Bytes by the tables of RFC 854, 855 and 2217.
STREAMS: list[tuple[str, list[Event]]] = [
    ("41 0d 00 42 0d 0a", [b"A\r\0B\r\n"]),
    ("ff ff", [b"\xff"]),
    ("61 ff fd 00 62", [b"a", Negotiation(DO, BINARY), b"b"]),
    ("ff fb 2c ff fe 01", [Negotiation(WILL, 44), Negotiation(DONT, 1)]),
    ("61 ff f1 62 ff f6 63", [b"abc"]),  # NOP and AYT are of no interest
    ("ff fa 2c 01 00 00 25 80 ff f0 61", [Subnegotiation(44, bytes.fromhex("01 00 00 25 80")), b"a"]),
    ("ff fa 2c 0b ff ff ff f0", [Subnegotiation(44, b"\x0b\xff")]),
    ("ff fa ff f0 61", [b"a"]),  # an empty one has no effect
    ("ff f0 61", [b"a"]),  # an end without a beginning
    (
        "ff fa 2c 01 ff fd 00 61",
        [Negotiation(DO, BINARY), b"a"],
    ),  # a command that is not allowed there: the first is given up
]


@pytest.mark.parametrize(("stream", "events"), STREAMS)
def test_stream_is_separated(stream: str, events: list[Event]) -> None:
    data = bytes.fromhex(stream)
    assert read(data) == events
    assert read(*(data[at : at + 1] for at in range(len(data)))) == events


def test_long_subnegotiation_is_skipped_to_its_end() -> None:
    long = b"\xff\xfa\x2c" + bytes(LONGEST_COMMAND) + b"\x01\xff\xff\x02"
    reader = TelnetReader()
    assert list(reader.feed(long)) == []
    assert list(reader.feed(bytes(5000))) == []
    assert list(reader.feed(b"\xff")) == []
    assert list(reader.feed(b"\xf0after")) == [b"after"]


@given(st.lists(st.binary(max_size=60) | st.sampled_from([b"\xff", b"\xff\xfa", b"\xff\xf0"]), max_size=20))
def test_no_bytes_are_an_error_and_pieces_do_not_matter(pieces: list[bytes]) -> None:
    assert read(*pieces) == read(b"".join(pieces))


@given(st.lists(st.binary(max_size=60), max_size=8))
def test_escaped_data_comes_back(pieces: list[bytes]) -> None:
    assert b"".join(event for event in read(*map(escape, pieces)) if isinstance(event, bytes)) == b"".join(pieces)


@given(st.integers(0, 254), st.binary(max_size=60))
def test_subnegotiation_comes_back(option: int, body: bytes) -> None:
    assert read(b"a" + subnegotiation(option, body) + b"b") == [b"a", Subnegotiation(option, body), b"b"]


class Wire:
    """Options with BINARY for both sides, and their answers."""

    def __init__(self) -> None:
        self.written = b""
        self.options = Options(frozenset({BINARY}), frozenset({BINARY}), self._write)

    def _write(self, data: bytes) -> None:
        self.written += data

    def answer(self, command: int, option: int) -> str:
        self.written = b""
        self.options.negotiate(command, option)
        return self.written.hex(" ")


def test_wanted_option_is_agreed_to_once() -> None:
    wire = Wire()
    assert wire.answer(DO, BINARY) == "ff fb 00"
    assert wire.answer(DO, BINARY) == ""
    assert wire.answer(WILL, BINARY) == "ff fd 00"
    assert wire.answer(WILL, BINARY) == ""


def test_unknown_option_is_declined() -> None:
    wire = Wire()
    assert wire.answer(DO, 24) == "ff fc 18"
    assert wire.answer(WILL, 24) == "ff fe 18"
    assert wire.answer(DONT, 24) == ""
    assert wire.answer(WONT, 24) == ""


def test_agreement_to_our_question_is_not_answered() -> None:
    wire = Wire()
    wire.options.ask(DO, BINARY)
    assert wire.written.hex(" ") == "ff fb 00"
    assert wire.answer(DO, BINARY) == ""
    assert BINARY in wire.options.in_force[DO]


def test_end_of_an_option_is_confirmed_once() -> None:
    wire = Wire()
    wire.answer(DO, BINARY)
    assert wire.answer(DONT, BINARY) == "ff fc 00"
    assert wire.answer(DONT, BINARY) == ""
    assert BINARY not in wire.options.in_force[DO]
