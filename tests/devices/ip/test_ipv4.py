"""IPv4 headers: RFC 791, 3.1; the checksum: RFC 1071."""

from ipaddress import IPv4Address

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.ip.checksum import checksum
from fieldrig_devices.ip.ipv4 import Packet

# A datagram to a port for name service, as Linux 6.1 sent it into a TUN device.
UDP = bytes.fromhex("450000219a794000401159f8bec86465bec8646481ca0035000df3a768656c6c6f")


def test_the_checksum_is_that_of_the_example_in_rfc_1071() -> None:
    assert checksum(bytes.fromhex("0001 f203 f4f5 f6f7")) == 0xDDF2 ^ 0xFFFF


def test_an_odd_byte_is_the_upper_one_of_a_word() -> None:
    assert checksum(bytes.fromhex("0001 f2")) == 0xF201 ^ 0xFFFF


def test_a_packet_of_linux_is_read() -> None:
    packet = Packet.decode(UDP)
    assert (packet.source, packet.destination) == (IPv4Address("190.200.100.101"), IPv4Address("190.200.100.100"))
    assert (packet.protocol, packet.identification, packet.time_to_live) == (17, 0x9A79, 64)
    assert packet.payload == UDP[20:]


def test_a_packet_is_written_as_linux_writes_it() -> None:
    addresses = IPv4Address("190.200.100.101"), IPv4Address("190.200.100.100")
    assert Packet(*addresses, 17, UDP[20:], 0x9A79).encode() == UDP


def test_padding_behind_a_packet_is_removed() -> None:
    assert Packet.decode(UDP + bytes(13)).payload == UDP[20:]


def test_options_are_skipped() -> None:
    packet = bytes.fromhex("46000018 00000000 4001b0e2 be c8 64 65 be c8 64 64 01010100".replace(" ", ""))
    header = packet[:10] + bytes(2) + packet[12:]
    right = header[:10] + checksum(header).to_bytes(2, "big") + header[12:]
    assert Packet.decode(right).payload == b""


@pytest.mark.parametrize(
    ("place", "value"),
    [(0, 0x65), (0, 0x44), (2, 0xFF), (10, 0x00), (8, 63)],
    ids=["version 6", "a header of 4 words", "longer than the data", "checksum", "a changed time to live"],
)
def test_damaged_headers_are_refused(place: int, value: int) -> None:
    with pytest.raises(ValueError, match=r"expected|checksum"):
        Packet.decode(UDP[:place] + bytes([value]) + UDP[place + 1 :])


@pytest.mark.parametrize(
    ("flags", "place"),
    [("2000", (0, True)), ("0001", (8, False)), ("3fff", (65_528, True)), ("4000", (0, False))],
    ids=["the first", "the last", "the highest place", "a packet that may not become fragments"],
)
def test_fragments_have_their_place(flags: str, place: tuple[int, bool]) -> None:
    header = UDP[:6] + bytes.fromhex(flags) + UDP[8:10] + bytes(2) + UDP[12:20]
    fragment = header[:10] + checksum(header).to_bytes(2, "big") + header[12:] + UDP[20:]
    packet = Packet.decode(fragment)
    assert (packet.offset, packet.has_more) == place
    assert packet.encode() == fragment


def test_a_payload_that_no_packet_has_room_for_is_refused() -> None:
    with pytest.raises(ValueError, match="expected at most 65535"):
        Packet(IPv4Address(0), IPv4Address(0), 6, bytes(65_516)).encode()


@settings(deadline=None)
@given(st.binary(max_size=64))
def test_arbitrary_bytes_are_read_or_refused(data: bytes) -> None:
    try:
        packet = Packet.decode(data)
    except ValueError:
        return
    assert len(packet.payload) <= len(data) - 20


@settings(deadline=None)
@given(st.binary(max_size=200).filter(any))
def test_data_with_their_checksum_sum_up_to_0(data: bytes) -> None:
    data += bytes(len(data) % 2)
    assert checksum(data + checksum(data).to_bytes(2, "big")) == 0
