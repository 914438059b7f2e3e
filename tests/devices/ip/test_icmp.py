"""ICMP: RFC 792, and RFC 1122, 3.2.2."""

from ipaddress import IPv4Address

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.ip import icmp
from fieldrig_devices.ip.ipv4 import Packet

# An echo and its reply as Linux 6.1 sent them.
ECHO = bytes.fromhex("0800 b644 35aa 0001 0001020304050607")
REPLY = bytes.fromhex("0000 be44 35aa 0001 0001020304050607")
UDP = bytes.fromhex("450000219a794000401159f8bec86465bec8646481ca0035000df3a768656c6c6f")


def test_an_echo_is_answered_with_its_identifier_number_and_data() -> None:
    assert icmp.answer(ECHO) == REPLY


@pytest.mark.parametrize("message", [REPLY, ECHO[:-1], ECHO[:7], b"", b"\x08\x01" + ECHO[2:]])
def test_everything_else_stays_without_an_answer(message: bytes) -> None:
    assert icmp.answer(message) is None


def test_a_refusal_quotes_the_header_and_8_bytes() -> None:
    refusal = icmp.unreachable(icmp.PORT_UNREACHABLE, Packet.decode(UDP))
    assert (refusal[:2], refusal[4:8], refusal[8:]) == (b"\x03\x03", bytes(4), UDP[:28])


@pytest.mark.parametrize("source", ["224.0.0.1", "0.0.0.0", "127.0.0.1", "255.255.255.255"])
def test_nothing_is_refused_to_many(source: str) -> None:
    assert not icmp.is_refusable(Packet(IPv4Address(source), IPv4Address("190.200.100.100"), 17, b""))


def test_icmp_is_never_refused() -> None:
    address = IPv4Address("190.200.100.101")
    assert not icmp.is_refusable(Packet(address, address, 1, b""))
    assert icmp.is_refusable(Packet(address, address, 17, b""))


@settings(deadline=None)
@given(st.binary(max_size=64))
def test_arbitrary_bytes_do_not_raise(data: bytes) -> None:
    icmp.answer(data)
