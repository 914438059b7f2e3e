"""Compressed TCP/IP headers: RFC 1144, and the option of RFC 1332, 4."""

import struct
from dataclasses import dataclass, replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ppp_bench import CALLER, CONTROLLER, CONTROLLER_END, PppBench, spaced

from fieldrig_devices.ip.checksum import checksum
from fieldrig_devices.ip.ipv4 import pseudo_header
from fieldrig_devices.ppp.phases import Phase
from fieldrig_devices.ppp.vj import Compressor, Decompressor

FIN, SYN, PSH, ACK, URG = 0x01, 0x02, 0x08, 0x10, 0x20


@dataclass(frozen=True)
class Sent:
    """A packet of TCP, with the fields that RFC 1144 compresses."""

    data: bytes = b""
    sequence: int = 1000
    acknowledgment: int = 2000
    window: int = 8192
    flags: int = ACK
    identification: int = 7
    urgent: int = 0
    port: int = 1024
    options: bytes = b""
    lifetime: int = 64
    fragment: int = 0x4000

    def encode(self) -> bytes:
        words = 5 + len(self.options) // 4
        fields = self.port, 80, self.sequence % 2**32, self.acknowledgment % 2**32, words << 4, self.flags, self.window
        rest = self.options + self.data
        tcp = struct.pack("!HHIIBBHHH", *fields, 0, self.urgent) + rest
        check = checksum(pseudo_header(CALLER, CONTROLLER, 6, len(tcp)) + tcp)
        tcp = struct.pack("!HHIIBBHHH", *fields, check, self.urgent) + rest
        start = 0x45, 0, 20 + len(tcp), self.identification % 65536, self.fragment, self.lifetime, 6
        ends = CALLER.packed, CONTROLLER.packed
        head = struct.pack("!BBHHHBBH4s4s", *start, 0, *ends)
        return struct.pack("!BBHHHBBH4s4s", *start, checksum(head), *ends) + tcp

    def then(self, **changes: object) -> "Sent":
        """Return the next packet of the host: its identification is higher by one."""
        return replace(self, identification=self.identification + 1, **changes)  # type: ignore[arg-type]

    @property
    def check(self) -> str:
        return self.encode()[36:38].hex()


def compressed(*packets: Sent, slots: int = 16, may_omit_slot: bool = True) -> list[str]:
    """Return what goes out for each packet: "IP", "whole" with its slot, or the changes in hex."""
    compressor, found = Compressor(slots, may_omit_slot=may_omit_slot), []
    for packet in packets:
        sent = compressor.compress(packet.encode())
        if sent is None:
            found.append("IP")
        else:
            found.append(sent[0].hex() if sent[1] else f"whole {sent[0][9]}")
    return found


ONE = Sent(b"abc")


# RFC 1144, 3.2.2 and A.2: change mask, checksum, and what has changed: urgent, window, acknowledgment, sequence, number
@pytest.mark.parametrize(
    ("following", "mask", "changes"),
    [
        (ONE.then(sequence=1003, data=b"de"), "0f", ""),
        (ONE.then(sequence=1003, acknowledgment=2003, data=b"d"), "0b", ""),
        (ONE.then(sequence=1003, acknowledgment=2001, data=b"d"), "0c", "01 03"),
        (ONE.then(sequence=1003, acknowledgment=2001, data=b"d", flags=ACK | PSH), "1c", "01 03"),
        (ONE.then(acknowledgment=2300), "04", "00012c"),
        (ONE.then(window=8191), "02", "00ffff"),
        (ONE.then(window=8447), "02", "ff"),
        (ONE.then(sequence=1003, window=8193), "0a", "01 03"),
        (ONE.then(sequence=1001, urgent=5, flags=ACK | URG), "09", "05 01"),
        (ONE.then(acknowledgment=2001, urgent=0, flags=ACK | URG), "05", "000000 01"),
        (replace(ONE, acknowledgment=2001, identification=9), "24", "01 02"),
        (replace(ONE, acknowledgment=2001, identification=7), "24", "01 000000"),
    ],
)
def test_a_packet_has_what_has_changed(following: Sent, mask: str, changes: str) -> None:
    expected = spaced(mask + following.check + changes) + following.data.hex()
    assert compressed(ONE, following) == ["whole 0", expected]


@pytest.mark.parametrize(
    "following",
    [
        ONE.then(), ONE.then(data=b""), ONE.then(data=b"abcd"), ONE.then(sequence=999),
        ONE.then(sequence=1000 + 65_536),
        ONE.then(acknowledgment=1999), ONE.then(urgent=1), ONE.then(options=bytes(4)), ONE.then(lifetime=63),
        ONE.then(fragment=0),
        ONE.then(sequence=1001, window=8193, urgent=1, flags=ACK | URG),  # the changes of a special case
        ONE.then(sequence=1001, acknowledgment=2001, window=8193, urgent=1, flags=ACK | URG),
    ],
)  # fmt: skip
def test_what_cannot_be_said_goes_out_whole(following: Sent) -> None:
    assert compressed(ONE, following) == ["whole 0", "whole 0"]


def test_data_behind_an_acknowledgment_are_compressed() -> None:
    """Nothing has changed but the length, and the packet before had no data (RFC 1144, A.2)."""
    following = ONE.then(data=b"de")
    assert compressed(replace(ONE, data=b""), following) == ["whole 0", "00" + following.check + "6465"]


@pytest.mark.parametrize(
    "packet",
    [
        replace(ONE, flags=SYN),
        replace(ONE, flags=ACK | FIN),
        replace(ONE, flags=ACK | 4),
        replace(ONE, fragment=0x2000),
    ],
)
def test_the_packets_of_a_begin_and_an_end_are_ip(packet: Sent) -> None:
    assert compressed(packet) == ["IP"]


def test_a_slot_is_named_when_it_changes_or_when_the_peer_wants_it() -> None:
    other = replace(ONE, port=1025)
    more, more_of_other = ONE.then(sequence=1003), other.then(sequence=1003)
    last = more.then(acknowledgment=2001)
    packets = (ONE, other, more, more_of_other, last)
    expected = [f"4f00{more.check}616263", f"4f01{more_of_other.check}616263", f"4400{last.check}01616263"]
    assert compressed(*packets) == ["whole 0", "whole 1", *expected]
    assert compressed(ONE, more, may_omit_slot=False) == ["whole 0", f"4f00{more.check}616263"]


def test_a_new_connection_takes_the_slot_that_was_used_longest_ago() -> None:
    ports = [replace(ONE, port=port) for port in (1, 2, 3)]
    assert compressed(*ports, slots=2) == ["whole 0", "whole 1", "whole 0"]
    assert compressed(ports[0], ports[1], ports[0], ports[2], slots=2)[-1] == "whole 1"


def restored(decompressor: Decompressor, sent: tuple[bytes, bool]) -> bytes:
    return (decompressor.compressed if sent[1] else decompressor.whole)(sent[0])


DELTAS = st.sampled_from([0, 1, 3, 255, 256, 65_535, 65_536, 2**31, -1, -300])
STEPS = st.tuples(
    DELTAS, DELTAS, st.integers(0, 65_535), st.sampled_from([ACK, ACK | PSH, ACK | URG, ACK | FIN, SYN]),
    st.integers(0, 3), st.sampled_from([0, 1, 2, 400]), st.binary(max_size=6), st.integers(0, 9), st.booleans(),
)  # fmt: skip


@settings(deadline=None)
@given(st.lists(STEPS, max_size=40), st.integers(1, 16), st.booleans())
def test_every_packet_is_restored(
    steps: list[tuple[int, int, int, int, int, int, bytes, int, bool]], slots: int, may_omit: bool
) -> None:
    compressor, decompressor = Compressor(slots, may_omit_slot=may_omit), Decompressor(slots)
    last: dict[int, Sent] = {}
    for sent, acknowledged, window, flags, port, step, data, urgent, repeats_window in steps:
        before = last.get(port, replace(ONE, port=port))
        follows = len(before.data) if repeats_window else sent
        packet = replace(
            before,
            sequence=(before.sequence + follows) % 2**32,
            acknowledgment=(before.acknowledgment + acknowledged) % 2**32,
            window=before.window if repeats_window else window,
            flags=flags,
            identification=before.identification + step,
            data=data,
            urgent=urgent if flags & URG else 0,
        )
        last[port] = packet
        found = compressor.compress(packet.encode())
        if found is not None:
            assert restored(decompressor, found) == packet.encode()
            assert len(found[0]) <= len(packet.encode())


@given(st.lists(st.tuples(st.binary(max_size=60), st.booleans()), max_size=20))
def test_no_bytes_raise_anything_but_value_error(pieces: list[tuple[bytes, bool]]) -> None:
    decompressor = Decompressor()
    decompressor.whole(Compressor(1, may_omit_slot=True).whole(ONE.encode(), 0))
    for data, is_compressed in pieces:
        try:
            packet = restored(decompressor, (data, is_compressed))
        except ValueError:
            continue
        assert len(packet) >= 40


def test_after_a_lost_frame_only_a_packet_with_its_slot_counts() -> None:
    compressor, decompressor = Compressor(16, may_omit_slot=True), Decompressor()
    for packet in (ONE, ONE.then(sequence=1003)):
        found = compressor.compress(packet.encode())
        assert found is not None
        restored(decompressor, found)
    decompressor.toss()
    found = compressor.compress(ONE.then(sequence=1006).encode())
    assert found is not None
    with pytest.raises(ValueError, match="after a frame was lost"):
        restored(decompressor, found)
    again = ONE.then(sequence=1003)
    found = compressor.compress(again.encode())  # sent again, so it is whole
    assert found is not None
    assert restored(decompressor, found) == again.encode()


# ---- over a link

COMPRESSING = replace(CONTROLLER_END, compresses_headers=True)
OURS = "8021 02 01 0010 0206 002d0f01 0306 bec86464"


def running(options: str = "0206 002d0f01") -> PppBench:
    bench = PppBench(COMPRESSING).log_in()
    length = 10 + len(bytes.fromhex(options))
    sent = bench.hear(OURS, f"8021 01 01 {length:04x} {options} 0306 bec86465")
    assert sent == [spaced(f"8021 02 01 {length:04x} {options} 0306 bec86465")]
    assert bench.link.phase is Phase.RUNNING
    return bench


@pytest.mark.manual("PD-260")
def test_both_ends_compress_if_both_have_asked() -> None:
    bench = running()
    following = ONE.then(sequence=1003, data=b"d")
    whole = bytearray(ONE.encode())
    whole[9] = 5
    bench.hear("002f" + whole.hex(), "002d0f" + following.check + "64")
    assert bench.packets == [ONE.encode(), following.encode()]
    for packet in (ONE, following):
        bench.link.send_ip(bench.now_ns, packet.encode())
    whole[9] = 0
    assert bench.take() == ["002f" + whole.hex(), "002d0f" + following.check + "64"]


def test_a_damaged_frame_drops_what_does_not_name_its_slot() -> None:
    bench = running()
    whole = bytearray(ONE.encode())
    whole[9] = 5
    bench.hear("002f" + whole.hex())
    bench.link.receive(bench.now_ns, b"\x7e\xff\x03\x00\x2d\x0f\x12\x7e")
    following = ONE.then(sequence=1003, data=b"d")
    bench.hear("002d0f" + following.check + "64")
    assert bench.packets == [ONE.encode()]
    bench.hear("002d4f05" + following.check + "64")
    assert bench.packets[1:] == [following.encode()]


def test_a_peer_that_did_not_ask_gets_plain_ip_and_may_send_it_compressed() -> None:
    bench = running("")
    bench.link.send_ip(bench.now_ns, ONE.encode())
    assert bench.take() == ["0021" + ONE.encode().hex()]


def test_a_peer_that_refuses_is_not_asked_again_and_its_compressed_packets_are_rejected() -> None:
    bench = PppBench(COMPRESSING).log_in()
    assert bench.hear("8021 04 01 000a 0206 002d0f01") == [spaced("8021 01 02 000a 0306 bec86464")]
    bench.hear("8021 02 02 000a 0306 bec86464", "8021 01 01 000a 0306 bec86465")
    (rejection,) = bench.hear("002d0f1234")
    assert rejection.startswith("c02108")


@pytest.mark.parametrize("option", ["0204 002d", "0206 002d0f02", "0204 0037", "0206 00030000"])
def test_another_compression_is_answered_with_ours(option: str) -> None:
    bench = PppBench(COMPRESSING).log_in()
    length = 10 + len(bytes.fromhex(option))
    assert bench.hear(f"8021 01 05 {length:04x} {option} 0306 bec86465") == [spaced("8021 03 05 000a 0206 002d0f01")]


def test_slots_are_those_that_the_peer_has() -> None:
    bench = running("0206 002d0200")
    for port in (1, 2, 3, 4):
        bench.link.send_ip(bench.now_ns, replace(ONE, port=port).encode())
    assert [packet[22:24] for packet in bench.take()] == ["00", "01", "02", "00"]
