"""TCP segments: RFC 9293, 3.1 and 3.2."""

from ipaddress import IPv4Address

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.ip.ipv4 import Packet
from fieldrig_devices.ip.tcp.segment import ACK, FIN, PSH, SYN, Flags, Segment, _mss

# The SYN of a connection to port 80, as Linux 6.1 sent it into a TUN device with an MTU of 1500.
LINUX_SYN = bytes.fromhex(
    "4500003c306740004006c3fabec86465bec86464"
    "c9f60050182fce6900000000a002faf08e070000020405b40402080a276ea05c000000000103030a"
)
# The same with all of its options but one switched off.
PLAIN_SYN = bytes.fromhex("4500002ce0ab4000400613c6bec86465bec86464c51400501ec413cb000000006002faf05ee70000020405b4")
CALLER, CONTROLLER = IPv4Address("190.200.100.101"), IPv4Address("190.200.100.100")


def test_a_syn_of_linux_is_read() -> None:
    packet = Packet.decode(LINUX_SYN)
    segment = Segment.decode(packet.payload, packet.source, packet.destination)
    assert segment == Segment(0xC9F6, 80, 0x182FCE69, 0, SYN, 64240, b"", 1460)


def test_a_syn_is_written_as_linux_writes_it() -> None:
    segment = Segment(0xC514, 80, 0x1EC413CB, 0, SYN, 64240, b"", 1460)
    assert segment.encode(CALLER, CONTROLLER) == PLAIN_SYN[20:]


@pytest.mark.parametrize(
    ("flags", "data", "length"), [(SYN, b"", 1), (ACK, b"", 0), (PSH | ACK, b"abc", 3), (FIN | ACK, b"abc", 4)]
)
def test_syn_and_fin_take_a_sequence_number(flags: Flags, data: bytes, length: int) -> None:
    assert Segment(1, 2, 0, 0, flags, 0, data).length == length


def test_the_checksum_covers_the_addresses() -> None:
    payload = Packet.decode(LINUX_SYN).payload
    with pytest.raises(ValueError, match="checksum"):
        Segment.decode(payload, CALLER, IPv4Address("190.200.100.99"))


@pytest.mark.parametrize(
    ("options", "mss"),
    [
        ("020405b4", 1460),
        ("01 01 020405b4", 1460),
        ("0402 08 0a 0000000000000000 020405b4", 1460),
        ("00 020405b4", None),  # behind the end of the list
        ("0400 020405b4", None),  # a length of 0
        ("0205 05b400", None),  # a length that is not that of a segment size
        ("0204 05", None),
        ("02", None),
    ],
)
def test_options_are_searched_for_the_segment_size(options: str, mss: int | None) -> None:
    assert _mss(bytes.fromhex(options)) == mss


@settings(deadline=None)
@given(st.binary(max_size=80))
def test_arbitrary_bytes_are_read_or_refused(data: bytes) -> None:
    try:
        segment = Segment.decode(data, CALLER, CONTROLLER)
    except ValueError:
        return
    assert len(segment.data) <= len(data) - 20


@settings(deadline=None)
@given(st.binary(max_size=40))
def test_arbitrary_options_do_not_raise(options: bytes) -> None:
    _mss(options)


@settings(deadline=None)
@given(
    st.integers(0, 0xFFFF),
    st.integers(0, 0xFFFF_FFFF),
    st.integers(0, 31),
    st.binary(max_size=100),
)
def test_a_segment_is_read_as_it_was_written(port: int, number: int, flags: int, data: bytes) -> None:
    segment = Segment(port, 65535 - port, number, 0xFFFF_FFFF - number, Flags(flags), port, data)
    assert Segment.decode(segment.encode(CALLER, CONTROLLER), CALLER, CONTROLLER) == segment
