"""Messages of a relay between processes: what is sent arrives, and nothing else does."""

from contextlib import suppress

from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.ip import codec
from fieldrig_bus.ip.message import (
    LARGEST,
    WINDOW,
    Closed,
    Consumed,
    Ended,
    IpPacket,
    KernelOffered,
    LinkDown,
    LinkUp,
    Offered,
    Opened,
    Portion,
    RelayMessage,
    check_sent,
)

names = st.text(st.characters(codec="utf-8"), max_size=50)
numbers = st.integers(0, 2**32 - 1)
ports = st.integers(1, 65_535)
channel = names, numbers, st.booleans()
messages: st.SearchStrategy[RelayMessage] = st.one_of(
    st.builds(Offered, st.lists(ports, max_size=5).map(tuple)),
    st.builds(Opened, names, numbers, ports),
    st.builds(Portion, *channel, st.binary(min_size=1, max_size=100) | st.just(bytes(LARGEST))),
    st.builds(Consumed, *channel, st.integers(1, WINDOW)),
    st.builds(Ended, *channel),
    st.builds(Closed, *channel, names),
    st.just(KernelOffered()),
    st.builds(LinkUp, names, st.ip_addresses(v=4), st.ip_addresses(v=4), ports, st.lists(ports, max_size=5).map(tuple)),
    st.builds(LinkDown, names, st.booleans(), names),
    st.builds(IpPacket, names, st.booleans(), st.binary(min_size=1, max_size=1500)),
)


@settings(deadline=None)
@given(messages)
def test_a_message_arrives_as_it_was_sent(message: RelayMessage) -> None:
    check_sent(message)
    assert codec.decode(codec.encode(message)) == message
    assert codec.show(message)


@settings(deadline=None)
@given(st.binary() | messages.map(codec.encode).flatmap(lambda data: st.integers(0, len(data)).map(lambda n: data[:n])))
def test_other_bytes_are_refused_with_a_value_error(data: bytes) -> None:
    with suppress(ValueError):
        message = codec.decode(data)
        assert codec.decode(codec.encode(message)) == message
