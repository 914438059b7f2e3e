"""Captures of other programs: link types, byte orders, and TCP streams that are put together.

Heads are laid out by hand from RFC 791, 8200, 9293 and the table of link types of tcpdump.org.
"""

import io
import struct
from collections.abc import Sequence
from dataclasses import replace
from ipaddress import IPv6Address
from itertools import pairwise
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read_trace, write
from fieldrig_bus.can.codec import decode, encode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BusState, CanState
from fieldrig_bus.modbus import codec as modbus_codec
from fieldrig_bus.modbus.message import ModbusMessage, ModbusRequest, ModbusResponse
from fieldrig_bus.traces import pcap
from fieldrig_bus.traces.ppp_frames import PppFinder

CLIENT, SERVER = ("10.0.0.2", 50_000), ("10.0.0.1", 502)
ASK = bytes.fromhex("0007 0000 0006 01 03 006b 0003")  # V1.1b3, 6.3
ANSWER = bytes.fromhex("0007 0000 0009 01 03 06 022b 0000 0064")
REQUEST, RESPONSE = ModbusRequest(1, ASK[7:], 7), ModbusResponse(1, ANSWER[7:], 7)


def tcp(source: tuple[str, int], target: tuple[str, int], sequence: int, data: bytes, flags: int = 0x18) -> bytes:
    return struct.pack("!HHIIHHHH", source[1], target[1], sequence & 0xFFFF_FFFF, 0, 5 << 12 | flags, 1000, 0, 0) + data


def ipv4(source: tuple[str, int], target: tuple[str, int], sequence: int, data: bytes, flags: int = 0x18) -> bytes:
    segment = tcp(source, target, sequence, data, flags)
    ends = bytes(int(part) for end in (source, target) for part in end[0].split("."))
    return struct.pack("!BBHHHBBH", 0x45, 0, 20 + len(segment), 1, 0x4000, 64, 6, 0) + ends + segment


def ipv6(data: bytes) -> bytes:
    segment = bytes((6, 0)) + bytes(6) + tcp(("", 50_000), ("", 502), 1, data)  # behind a header of hop-by-hop options
    ends = IPv6Address("fe80::2").packed + IPv6Address("fe80::1").packed
    return struct.pack("!IHBB", 6 << 28, len(segment), 0, 64) + ends + segment


def capture(link_type: int, packets: Sequence[bytes], order: str = "<", magic: int = 0xA1B2C3D4) -> bytes:
    head = struct.pack(f"{order}IHHIIII", magic, 2, 4, 0, 0, 65_535, link_type)
    records = (struct.pack(f"{order}IIII", 1, 500, len(packet), len(packet)) + packet for packet in packets)
    return head + b"".join(records)


def read(data: bytes, odd: Oddities | None = None) -> list[TraceEntry]:
    return list(pcap.read(io.BytesIO(data), odd))


def acknowledging(packet: bytes, number: int) -> bytes:
    """Return an IPv4 packet whose segment acknowledges the bytes before a number."""
    return packet[:28] + struct.pack("!I", number) + packet[32:]


def messages(*packets: bytes, odd: Oddities | None = None) -> list[ModbusMessage]:
    found = [modbus_codec.decode(entry.data) for entry in read(capture(228, packets), odd)]
    return [one for one in found if isinstance(one, ModbusRequest | ModbusResponse)]


@pytest.mark.parametrize(("order", "magic", "unit_ns"), [("<", 0xA1B2C3D4, 1000), (">", 0xA1B23C4D, 1)])
def test_both_byte_orders_and_units_are_read(order: str, magic: int, unit_ns: int) -> None:
    (found,) = read(capture(227, [bytes.fromhex("00000123 01 00 0000 aa")], order, magic))
    assert (found.time_ns, found.bus) == (1_000_000_000 + 500 * unit_ns, "can0")
    assert decode(found.data) == CanFrame(0x123, b"\xaa")


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_file_of_the_patched_libpcap_has_longer_heads_of_packets(order: str) -> None:
    packet, further = bytes.fromhex("00000123 01 00 0000 aa"), bytes.fromhex("0000000300000000")
    record = struct.pack(f"{order}IIII", 2, 7, len(packet), len(packet)) + further + packet
    found = read(capture(227, [], order, 0xA1B2CD34) + record * 2)
    assert [(one.time_ns, decode(one.data)) for one in found] == [(2_000_007_000, CanFrame(0x123, b"\xaa"))] * 2


IP = ipv4(CLIENT, SERVER, 1, ASK)
LINKS = [
    (0, struct.pack("<I", 2) + IP),
    (0, struct.pack(">I", 2) + IP),
    (1, bytes(12) + b"\x08\x00" + IP + bytes(6)),
    (1, bytes(12) + bytes.fromhex("8100 0005 88a8 0006 0800") + IP),
    (1, bytes(12) + b"\x86\xdd" + ipv6(ASK)),
    (1, bytes(12) + bytes.fromhex("8864 1100 0001 0000 0021") + IP),
    (1, bytes(12) + bytes.fromhex("8100 0005 8864 1100 0001 0000 0057") + ipv6(ASK)),
    (9, bytes.fromhex("ff03 0021") + IP),
    (9, bytes.fromhex("21") + IP),
    (12, IP),
    (101, IP),
    (101, ipv6(ASK)),
    (108, struct.pack(">I", 2) + IP),
    (113, bytes(14) + b"\x08\x00" + IP),
    (204, bytes.fromhex("01 ff03 0021") + IP),
    (228, IP),
    (229, ipv6(ASK)),
    (276, b"\x08\x00" + bytes(18) + IP),
]


@pytest.mark.parametrize(
    ("link_type", "packet"), LINKS, ids=[f"{number}-{link}" for number, (link, _) in enumerate(LINKS)]
)
def test_modbus_is_found_behind_every_link(link_type: int, packet: bytes) -> None:
    (found,) = read(capture(link_type, [packet]))
    assert modbus_codec.decode(found.data) == REQUEST
    assert found.sender in ("10.0.0.2:50000", "[fe80::2]:50000")


@pytest.mark.parametrize(("link_type", "head"), [(113, bytes(14) + b"\x00\x0c"), (276, b"\x00\x0d" + bytes(18))])
def test_can_is_found_in_captures_of_any_interface(link_type: int, head: bytes) -> None:
    (found,) = read(capture(link_type, [head + bytes.fromhex("80000005 01 00 0000 aa")]))
    assert found.bus == "can0"
    assert decode(found.data) == CanFrame(5, b"\xaa", is_extended=True)


def test_can_interfaces_of_a_cooked_capture_are_told_apart_by_their_numbers() -> None:
    packets = [
        bytes.fromhex(f"000c0000{index:08x}011800000000000000000000") + bytes.fromhex("0000012301000000aa")
        for index in (7, 3, 7)
    ]
    odd = Oddities()
    assert [one.bus for one in read(capture(276, packets), odd)] == ["can0", "can1", "can0"]
    [said] = map(str, odd)
    assert said.endswith("interfaces of a cooked capture have only numbers: can0 is 7 (2 times in all)")


CAN_PACKETS = [
    ("00000123 02 00 0000 aabb", CanFrame(0x123, b"\xaa\xbb")),
    ("9abcdef0 00 00 0000", CanFrame(0x1ABCDEF0, is_extended=True)),
    ("40000123 04 00 0000", CanFrame(0x123, is_remote=True, remote_length=4)),
    ("00000123 01 05 0000 aa", CanFrame(0x123, b"\xaa", is_fd=True, is_bit_rate_switched=True)),
    ("00000123 01 00 0000 aa" + "00" * 63, CanFrame(0x123, b"\xaa", is_fd=True)),
    ("20000204 08 00 0000 0020 00000000 8405", BusState(CanState.PASSIVE, 0x84, 5)),
]


@pytest.mark.parametrize(("packet", "message"), CAN_PACKETS)
def test_can_packets_are_those_of_socketcan(packet: str, message: CanFrame | BusState) -> None:
    (found,) = read(capture(227, [bytes.fromhex(packet)]))
    assert decode(found.data) == message


@pytest.mark.parametrize(
    "packet", ["20000080 08 00 0000" + "00" * 8, "0000", "00000123 09 00 0000 01", "00000fff 00 00 0000"]
)
def test_can_packets_that_are_no_frames_are_counted(packet: str) -> None:
    odd = Oddities()
    assert read(capture(227, [bytes.fromhex(packet)] * 2), odd) == []
    assert [str(oddity) for oddity in odd] == [
        "packet 1: CAN packets that are no frame, error or state are left out (2 times in all)"
    ]


def test_serial_captures_have_the_bytes_of_each_end() -> None:
    """LINKTYPE_RTAC_SERIAL: time, event, lines, footer; 1 and 2 are the start of data that is sent and received."""
    events = [(1, b"AT\r"), (2, b"OK\r\n"), (0, b""), (9, b""), (5, b"")]
    packets = [struct.pack("!IIBBH", 1, 2, event, 0, 0) + data for event, data in events]
    odd = Oddities()
    found = read(capture(250, packets), odd)
    assert [(entry.family, entry.sender, entry.data) for entry in found] == [
        ("serial", "tx", b"\0AT\r"),
        ("serial", "rx", b"\0OK\r\n"),
        ("serial", "", b"\3\0\0\0\0"),
    ]
    assert [oddity.what for oddity in odd] == ["the capture has lost bytes of a serial line"]
    assert read(capture(147, [b"AT\r"]))[0].data == b"\0AT\r"


def test_a_capture_of_ppp_is_read_as_the_bytes_of_the_line() -> None:
    """The frames come out again where the line's bytes are read (RFC 1662); without address and control too."""
    lcp = bytes.fromhex("ff03 c021 01 01 0008 0304 c023")
    (first, second) = read(capture(9, [lcp, lcp[2:]]))
    assert first.family == "serial"
    assert first.data == second.data
    assert first.data[:4] == b"\0\x7e\xff\x7d"
    assert PppFinder().feed("", first.data[1:]) == [lcp]


def test_the_line_below_modbus_over_ppp_is_a_bus_of_its_own(tmp_path: Path) -> None:
    """A bus has messages of one family: in pcapng Modbus was written as bytes of the line."""
    packets = [bytes.fromhex("ff03 c021 01 01 0008 0304 c023"), bytes.fromhex("ff03 0021") + IP]
    log, copy = tmp_path / "a.pcap", tmp_path / "a.pcapng"
    log.write_bytes(capture(9, packets))
    write(read_trace(log), copy)
    for path in (log, copy):
        found = [(entry.bus, entry.family) for entry in read_trace(path)]
        assert found == [("modbus-ppp", "serial"), ("modbus", "modbus")]


def test_a_stream_is_put_together_from_any_segments() -> None:
    """Two requests in one segment, an answer in three, which come out of order and twice, and wrap around."""
    begin = 0xFFFF_FFF8
    requests = ASK + ASK
    parts = [(0, ANSWER[:4]), (7, ANSWER[7:]), (4, ANSWER[4:9]), (0, ANSWER[:4])]
    found = messages(
        ipv4(CLIENT, SERVER, 5, requests),
        *(ipv4(SERVER, CLIENT, begin + at, data) for at, data in parts),
        ipv4(SERVER, CLIENT, begin + len(ANSWER), ANSWER),
    )
    assert found == [REQUEST, REQUEST, RESPONSE, RESPONSE]


@pytest.mark.long
@given(
    st.lists(st.integers(1, 253), min_size=1, max_size=8), st.integers(0, 2**32 - 1), st.randoms(use_true_random=False)
)
@settings(deadline=None)
def test_any_cut_and_order_of_segments_gives_the_same_messages(sizes: list[int], begin: int, chance: Random) -> None:
    sent = [ModbusResponse(1, bytes((3,)) + chance.randbytes(size - 1), number) for number, size in enumerate(sizes)]
    stream = b"".join(struct.pack("!HHHB", one.exchange, 0, 1 + len(one.pdu), 1) + one.pdu for one in sent)
    cuts = sorted({0, len(stream), *(chance.randrange(len(stream)) for _ in range(6))})
    parts = [(at, stream[at:end]) for at, end in pairwise(cuts)]
    parts += chance.sample(parts, len(parts) // 2)  # again
    chance.shuffle(parts)
    opening = ipv4(SERVER, CLIENT, begin - 1, b"", 0x12)
    assert messages(opening, *(ipv4(SERVER, CLIENT, begin + at, data) for at, data in parts)) == sent


def test_a_lost_segment_loses_only_its_messages() -> None:
    odd = Oddities()
    found = messages(
        ipv4(CLIENT, SERVER, 1, ASK),
        ipv4(CLIENT, SERVER, 1 + 12 + 6, ASK[6:]),  # the end of a request whose beginning was not captured
        ipv4(CLIENT, SERVER, 1 + 24, ASK),
        odd=odd,
    )
    assert found == [REQUEST, REQUEST]
    assert "bytes of a TCP stream are missing in the capture" in [oddity.what for oddity in odd]


@pytest.mark.parametrize("acknowledged", [ANSWER, b""], ids=["answer", "bare acknowledgements"])
def test_a_lost_segment_that_was_acknowledged_holds_nothing_up(acknowledged: bytes) -> None:
    """A request is not in the capture, but the server has got it, so the next one waits for it no longer."""
    later = acknowledging(ipv4(SERVER, CLIENT, 900, acknowledged), 1 + 36)
    again = [] if acknowledged else [later]
    found = messages(
        ipv4(CLIENT, SERVER, 1, ASK),
        acknowledging(ipv4(SERVER, CLIENT, 900 - len(ANSWER), ANSWER), 13),
        ipv4(CLIENT, SERVER, 1 + 24, ASK),
        later,
        *again,
        ipv4(SERVER, CLIENT, 900 + len(acknowledged), ANSWER),
    )
    assert found == [REQUEST, RESPONSE, REQUEST, *([RESPONSE] if acknowledged else []), RESPONSE]


def test_an_acknowledgement_shortly_before_its_segment_loses_nothing() -> None:
    """Packets of both directions may be captured in a slightly other order."""
    found = messages(
        ipv4(CLIENT, SERVER, 1, ASK),
        ipv4(CLIENT, SERVER, 1 + 24, ASK),
        acknowledging(ipv4(SERVER, CLIENT, 900, b""), 1 + 36),
        ipv4(CLIENT, SERVER, 1 + 12, ASK),
    )
    assert found == [REQUEST] * 3


def test_a_capture_that_begins_within_a_message_finds_the_next_one() -> None:
    odd = Oddities()
    found = messages(ipv4(SERVER, CLIENT, 9, ANSWER[5:] + ANSWER + ANSWER[:9]), odd=odd)
    assert found == [RESPONSE]
    assert [oddity.what for oddity in odd] == [
        "bytes that are no Modbus TCP are left out",
        "messages at the end of the capture are cut off",
    ]


def test_a_packet_that_was_captured_in_part_is_a_gap() -> None:
    odd = Oddities()
    whole = ipv4(CLIENT, SERVER, 1, ASK + ASK)
    assert messages(whole[:-3], ipv4(CLIENT, SERVER, 25, ASK), odd=odd) == [REQUEST]
    assert [oddity.what for oddity in odd] == ["bytes of a TCP stream are missing in the capture"]


def test_another_port_is_recognised_by_its_first_segment() -> None:
    client, server = ("10.0.0.2", 1500), ("10.0.0.1", 15_020)
    opening = ipv4(client, server, 0, b"", 0x02)
    assert messages(opening, ipv4(client, server, 1, ASK), ipv4(server, client, 1, ANSWER)) == [REQUEST, RESPONSE]
    odd = Oddities()
    assert messages(ipv4(client, ("10.0.0.1", 80), 1, b"GET / HTTP/1.0\r\n\r\n"), odd=odd) == []
    assert [oddity.what for oddity in odd] == ["TCP segments without Modbus are left out"]


def test_a_connection_of_the_same_ports_begins_again() -> None:
    found = messages(
        ipv4(CLIENT, SERVER, 1, ASK),
        ipv4(CLIENT, SERVER, 13, b"", 0x11),
        ipv4(CLIENT, SERVER, 0x7000_0000, b"", 0x02),
        ipv4(CLIENT, SERVER, 0x7000_0001, ASK),
    )
    assert found == [REQUEST, replace(REQUEST, exchange=0x1_0007)]


def test_connections_with_the_same_transaction_have_exchanges_of_their_own() -> None:
    other = ("10.0.0.9", 1500)
    found = messages(
        ipv4(CLIENT, SERVER, 1, ASK),
        ipv4(other, SERVER, 1, ASK),
        ipv4(SERVER, other, 1, ANSWER),
        ipv4(SERVER, CLIENT, 1, ANSWER),
    )
    assert found == [
        REQUEST,
        replace(REQUEST, exchange=0x1_0007),
        replace(RESPONSE, exchange=0x1_0007),
        RESPONSE,
    ]


def test_a_segment_that_is_sent_again_after_the_end_is_not_read_again() -> None:
    """A host that has not seen the acknowledgement of its FIN sends the last segment again."""
    last = ipv4(SERVER, CLIENT, 1, ANSWER, 0x19)
    assert messages(last, last, ipv4(SERVER, CLIENT, 1, b"", 0x14), last) == [RESPONSE]
    assert messages(last, ipv4(SERVER, CLIENT, 0x7000_0000, ANSWER)) == [RESPONSE, RESPONSE]


def test_a_fragment_and_another_protocol_are_counted() -> None:
    odd = Oddities()
    fragment = bytearray(IP)
    fragment[6] = 0x20
    assert messages(bytes(fragment), b"\x45" + bytes(30), b"", odd=odd) == []
    assert [(oddity.what, oddity.count) for oddity in odd] == [
        ("packets without messages of a bus that is known are left out", 3)
    ]


def test_an_unknown_link_type_is_named() -> None:
    odd = Oddities()
    assert read(capture(105, [b"wifi"]), odd) == []
    assert str(next(iter(odd))) == "packet 1: packets of link types that are not known are left out, of type 105"


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "the file is empty"),
        (capture(1, [])[:20], "the file does not begin with the head of a capture"),
        (capture(1, []) + struct.pack("<IIII", 0, 0, 0xFFFF_FFFF, 1), "packet 1 at byte 24 claims to have 4294967295"),
    ],
)
def test_a_file_that_is_no_capture_is_refused(data: bytes, reason: str) -> None:
    with pytest.raises(UsageError) as refused:
        read(data)
    assert refused.value.what.startswith(reason)


def test_a_cut_capture_is_read_as_far_as_it_goes() -> None:
    data = capture(228, [IP, IP])
    for size in range(25, len(data) - 1):
        odd = Oddities()
        assert len(read(data[:size], odd)) == (size >= 24 + 16 + len(IP))
        assert len(odd) == (size != 24 + 16 + len(IP))


@given(st.sampled_from([0, 1, 9, 101, 113, 204, 227, 250, 276]), st.lists(st.binary(max_size=80), max_size=3))
def test_no_packet_is_a_fault_of_ours(link_type: int, packets: list[bytes]) -> None:
    read(capture(link_type, packets))
    read(capture(link_type, [packet + IP for packet in packets]))


def test_messages_are_written_and_come_back() -> None:
    frames = [CanFrame(0x123, b"\x01"), CanFrame(0x5, bytes(12), is_extended=True, is_fd=True)]
    can = [TraceEntry(10**18 + number, "can0", "can", "", encode(frame)) for number, frame in enumerate(frames)]
    modbus = [
        TraceEntry(7, "modbus", "modbus", "10.0.1.1:49153", modbus_codec.encode(REQUEST)),
        TraceEntry(9, "modbus", "modbus", "10.0.0.1:502", modbus_codec.encode(RESPONSE)),
    ]
    for sent in (can, modbus):
        file, odd = io.BytesIO(), Oddities()
        assert pcap.write(sent, file, 0, odd) == 2
        assert (read(file.getvalue()), len(odd)) == (sent, 0)
    file, odd = io.BytesIO(), Oddities()
    assert pcap.write([*can, *modbus, can[0]._replace(bus="can1")], file, 0, odd) == 3
    assert [oddity.what for oddity in odd] == ["the format has no buses, so their messages are not kept apart"]


def test_room_on_a_disk_that_was_never_written_ends_a_capture() -> None:
    odd = Oddities()
    head = struct.pack("<IHHIIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 227)
    packet = bytes.fromhex("0000018101000000 05".replace(" ", ""))
    data = head + struct.pack("<IIII", 5, 0, len(packet), len(packet)) + packet + bytes(10 << 20)
    assert [one.time_ns for one in pcap.read(io.BytesIO(data), odd)] == [5_000_000_000]
    assert "the rest of the file is zeros, from byte 49 on" in [str(one).partition(": ")[2] for one in odd]


def test_an_answer_whose_first_segment_comes_late_begins_where_the_client_waits_for_it() -> None:
    """The capture begins without the opening of the connection."""
    asked = acknowledging(ipv4(CLIENT, SERVER, 1, ASK), 900)
    late, first = ipv4(SERVER, CLIENT, 907, ANSWER[7:]), ipv4(SERVER, CLIENT, 900, ANSWER[:7])
    odd = Oddities()
    assert messages(asked, late, first, late, odd=odd) == [REQUEST, RESPONSE]
    assert not list(odd)


def test_an_answer_that_begins_with_a_message_waits_for_none_before_it() -> None:
    asked = acknowledging(ipv4(CLIENT, SERVER, 1, ASK), 900)
    assert messages(asked, ipv4(SERVER, CLIENT, 990, ANSWER)) == [REQUEST, RESPONSE]
