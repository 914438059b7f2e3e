"""Messages of TCP between processes, and the way of messages between port and devices."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.tcp import codec
from fieldrig_bus.tcp.message import (
    MOST_DATA,
    Close,
    Connected,
    Data,
    Ended,
    Listen,
    Listening,
    Taken,
    TcpMessage,
    Unlisten,
)
from fieldrig_bus.tcp.model import PORT, TcpModel

numbers = st.integers(1, 2**32 - 1)
addresses = st.ip_addresses().map(str)
services = st.from_regex(r"[a-z][a-z0-9_-]{0,31}", fullmatch=True) | st.just("")
messages: st.SearchStrategy[TcpMessage] = st.one_of(
    st.builds(Connected, numbers, services, addresses, addresses, st.integers(0, 2**32 - 1)),
    st.builds(Data, numbers, st.binary(min_size=1, max_size=200)),
    st.builds(Taken, numbers, numbers),
    st.builds(Listening, numbers, st.integers(0, 65_535)),
    st.builds(Ended, numbers, st.booleans()),
    *(st.builds(kind, numbers) for kind in (Close, Listen, Unlisten)),
)


@given(messages)
def test_what_is_sent_arrives(message: TcpMessage) -> None:
    assert codec.decode(codec.encode(message)) == message
    assert "\n" not in codec.show(message)


@given(st.binary(max_size=40))
def test_other_bytes_are_refused_with_a_value_error(data: bytes) -> None:
    with suppress(ValueError):
        assert codec.encode(codec.decode(data)) == data


@pytest.mark.parametrize(
    ("message", "data"),
    [
        (Data(1, b"GET"), "01 01 00 00 00 47 45 54"),
        (Close(258), "04 02 01 00 00"),
        (Close(1, "a b"), "04 01 00 00 00 61 20 62"),
        (Listening(1, 50_000), "06 01 00 00 00 50 c3 00 00"),
        (Connected(1, "http", "::1", "::1"), "00 01 00 00 00 00 00 00 00 68 74 74 70 0a 3a 3a 31 0a 3a 3a 31"),
    ],
)
def test_bytes_between_processes(message: TcpMessage, data: str) -> None:
    assert codec.encode(message).hex(" ") == data


class Model:
    def __init__(self, *members: str) -> None:
        self.model = TcpModel()
        for member in (PORT, *members):
            self.model.join(member)
            self.model.listen(0, member, None if member == PORT else [member])

    def sends(self, member: str, *messages: TcpMessage) -> list[tuple[TcpMessage, str]]:
        """Return the messages that arrive, with their receivers."""
        for message in messages:
            self.model.submit(0, member, message)
        return [(delivery.message, ",".join(delivery.receivers)) for delivery in self.model.collect(0)]


def test_a_connection_goes_to_the_device_with_its_service_and_stays_there() -> None:
    model = Model("http", "ftp")
    connected = Connected(1, "ftp", "::1", "::1")
    assert model.sends(PORT, connected, Data(1, b"USER")) == [(connected, "ftp"), (Data(1, b"USER"), "ftp")]
    assert model.sends("ftp", Data(1, b"331")) == [(Data(1, b"331"), PORT)]
    assert model.sends("http", Data(1, b"not mine")) == [(Data(1, b"not mine"), "")]
    extra = Connected(2, "", "::1", "::1", 1)
    assert model.sends(PORT, extra) == [(extra, "ftp")]
    assert model.sends("ftp", Close(1)) == [(Close(1), PORT)]
    assert model.sends(PORT, Data(1, b"late")) == [(Data(1, b"late"), "")]


def test_a_service_that_no_device_has_is_closed() -> None:
    model = Model("http")
    assert model.sends(PORT, Connected(1, "ftp", "::1", "::1")) == [(Close(1), PORT)]
    assert model.sends(PORT, Connected(2, "", "::1", "::1", 9)) == [(Close(2), PORT)]


def test_connections_of_a_device_that_leaves_are_closed() -> None:
    model = Model("http", "ftp")
    model.sends(PORT, Connected(1, "http", "::1", "::1"), Connected(2, "ftp", "::1", "::1"))
    model.model.leave("http")
    assert model.sends(PORT) == [(Close(1), PORT)]


def test_data_have_a_limit() -> None:
    codec.decode(codec.encode(Data(1, bytes(MOST_DATA))))
    with pytest.raises(ValueError, match="16384"):
        codec.decode(codec.encode(Data(1, bytes(MOST_DATA + 1))))
