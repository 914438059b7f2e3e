"""PPP frames in words; the bytes are written by hand from RFC 1661, 1332, 1334, 791 and 9293."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.ppp.frame_words import frame_words, ip_words


@pytest.mark.parametrize(
    ("frame", "kind", "text"),
    [
        ("ff03 c021 02 07 0008 01 04 05dc", "PPP LCP", "Configure-Ack 7: MRU 1500"),
        ("ff03 c021 05 09 0004", "PPP LCP", "Terminate-Request 9"),
        ("ff03 c021 63 09 0004", "PPP LCP", "code 99 9"),
        ("ff03 8021 03 01 000a 03 06 bec86465", "PPP IPCP", "Configure-Nak 1: IP address 190.200.100.101"),
        ("ff03 8021 01 01 000a 02 06 002d0f01", "PPP IPCP", "Configure-Request 1: compression protocol 002D0F01h"),
        ("c023 01 02 000f 03 6c6162 06 67656865696d", "PPP PAP", "Authenticate-Request 2: user 'lab'"),
        ("c023 03 02 0005 00", "PPP PAP", "Authenticate-Nak 2"),
        ("2d 0102", "PPP VJ compressed TCP", "2 bytes"),
        ("ff03 c223 01", "PPP CHAP", "1 bytes"),
        ("ff03 1235 01", "PPP 1235h", "1 bytes"),
        ("ff03 c021 01 01 0063", "PPP LCP", "01 01 00 63"),
        ("ff", "PPP", "FF"),
    ],
)
def test_a_frame_says_its_protocol_and_what_it_asks(frame: str, kind: str, text: str) -> None:
    assert frame_words(bytes.fromhex(frame)) == (kind, text)


def test_a_password_is_not_shown() -> None:
    assert "geheim" not in frame_words(bytes.fromhex("c023 01 02 000f 03 6c6162 06 67656865696d"))[1]


def test_an_ip_packet_has_its_ends() -> None:
    ping = bytes.fromhex("4500001c000000004001 2f49 be c8 64 65 be c8 64 64 0800 f7ff 0000 0000")
    assert ip_words(_summed(ping)) == "190.200.100.101 to 190.200.100.100 ICMP, 8 bytes"


def _summed(packet: bytes) -> bytes:
    """Return the packet with the checksum of its header (RFC 791, 3.1)."""
    head = bytearray(packet[:20])
    head[10:12] = b"\0\0"
    total = sum(int.from_bytes(head[at : at + 2], "big") for at in range(0, 20, 2))
    while total > 0xFFFF:
        total = (total & 0xFFFF) + (total >> 16)
    head[10:12] = (total ^ 0xFFFF).to_bytes(2, "big")
    return bytes(head) + packet[20:]


@given(st.binary(max_size=60))
def test_any_frame_has_some_words(frame: bytes) -> None:
    for protocol in (b"", b"\xc0\x21", b"\x80\x21", b"\xc0\x23", b"\x00\x21"):
        kind, text = frame_words(protocol + frame)
        assert kind.startswith("PPP")
        assert isinstance(text, str)
