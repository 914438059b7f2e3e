"""pcapng files.  Packets are laid out by hand from tcpdump.org's link types and the RFCs of IP and TCP."""

import contextlib
import io
import struct
import warnings
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pcapng import blocks, scanner

from fieldrig.errors import RigError, UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can import codec as can_codec
from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import CanError, ErrorKind, FaultNote, Notice
from fieldrig_bus.modbus import codec as modbus_codec
from fieldrig_bus.modbus.message import (
    ClientConnected,
    LineState,
    ModbusEvent,
    ModbusMessage,
    ModbusRequest,
    ModbusResponse,
)
from fieldrig_bus.traces import pcapng
from fieldrig_bus.traces.modbus_packet import PacketMaker, messages_in

START_UNIX_NS = 1_700_000_000_123_456_789
ASK = ModbusRequest(1, bytes.fromhex("03 00 6b 00 03"), 7)  # V1.1b3, 6.3: the example
ANSWER = ModbusResponse(1, bytes.fromhex("03 06 02 2b 00 00 00 64"), 3)


def can(frame: CanFrame | Notice, time_ns: int = 0, bus: str = "can0", sender: str = "io") -> TraceEntry:
    return TraceEntry(time_ns, bus, "can", sender, can_codec.encode(frame))


def modbus(message: ModbusEvent, sender: str, time_ns: int = 0, bus: str = "mb") -> TraceEntry:
    return TraceEntry(time_ns, bus, "modbus", sender, modbus_codec.encode(message))


ENTRIES = [
    can(CanFrame(0x123, b"\x01\x02"), 5),
    can(CanFrame(0x123, is_remote=True, remote_length=4), 6, sender="tcp:1"),
    can(CanFrame(0x1ABCDEF0, bytes(range(64)), is_extended=True, is_fd=True, is_bit_rate_switched=True), 1 << 40),
    can(CanFrame(0x1, b"", is_fd=True), 8, bus="can1"),
    can(CanError(ErrorKind.BIT, Place.DATA, 20, 0x123, True, False, 8, 0), 8),
    can(FaultNote(1, "dropped"), 8),
    modbus(ClientConnected("10.0.0.9"), "tcp:1", 9),
    modbus(ASK, "tcp:1", 9),
    modbus(ANSWER, "drive", 10),
    modbus(ModbusRequest(2, b"\x11", 70_000, LineState(3, 4, True)), "rtu", 11, bus="line"),
    TraceEntry(12, "com1", "serial", "modem", b"\x00AT\r"),
    TraceEntry(13, "wires", "wires", "tank", b'["tank.level",0.5,"m"]'),
]


def written(*entries: TraceEntry) -> bytes:
    file = io.BytesIO()
    assert pcapng.write(entries, file, START_UNIX_NS) == len(entries)
    return file.getvalue()


def read(data: bytes) -> list[TraceEntry]:
    return list(pcapng.read(io.BytesIO(data)))


def packets(*entries: TraceEntry) -> list[Any]:
    return [block for block in scan(written(*entries)) if isinstance(block, blocks.EnhancedPacket)]


def scan(data: bytes) -> list[Any]:
    file_scanner: Any = scanner.FileScanner
    with warnings.catch_warnings():  # of its own table
        warnings.simplefilter("ignore", DeprecationWarning)
        return list(file_scanner(io.BytesIO(data)))


def test_what_was_written_is_read() -> None:
    assert read(written(*ENTRIES)) == ENTRIES


def test_bus_is_an_interface_with_nanoseconds() -> None:
    found = [block for block in scan(written(*ENTRIES)) if isinstance(block, blocks.InterfaceDescription)]
    assert [(block.options["if_name"], block.link_type) for block in found] == [
        ("can0", 227),
        ("can1", 227),
        ("mb", 228),
        ("line", 228),
        ("com1", 147),
        ("wires", 147),
    ]
    assert {block.options["if_tsresol"] for block in found} == {b"\x09"}


def test_packet_has_the_time_of_the_day_and_its_sender() -> None:
    (packet,) = packets(can(CanFrame(1), 1000))
    assert packet.timestamp_high << 32 | packet.timestamp_low == START_UNIX_NS + 1000
    assert packet.options.get_all("opt_comment") == ["io"]


# LINKTYPE_CAN_SOCKETCAN: identifier and flags big-endian, length, FD flags, two reserved bytes, data
CAN_PACKETS = [
    (CanFrame(0x123, b"\xaa\xbb"), "00 00 01 23 02 00 00 00 aa bb"),
    (CanFrame(0x1ABCDEF0, is_extended=True), "9a bc de f0 00 00 00 00"),
    (CanFrame(0x123, is_remote=True, remote_length=4), "40 00 01 23 04 00 00 00"),
    (CanFrame(0x123, b"\xaa", is_fd=True), "00 00 01 23 01 04 00 00 aa"),
    (CanFrame(0x123, b"\xaa", is_fd=True, is_bit_rate_switched=True), "00 00 01 23 01 05 00 00 aa"),
]


@pytest.mark.parametrize(("frame", "packet"), CAN_PACKETS)
def test_can_frame_is_socketcans(frame: CanFrame, packet: str) -> None:
    assert packets(can(frame))[0].packet_data.hex(" ") == packet


def test_modbus_message_is_a_tcp_segment() -> None:
    """Checksums were computed by Wireshark, which finds them correct (tests/real)."""
    maker = PacketMaker(2)
    asked, answered = maker.make("tcp:1", ASK), maker.make("drive", ANSWER)
    assert asked[12:20] == bytes((10, 2, 1, 1, 10, 2, 0, 1))
    assert answered[12:20] == bytes((10, 2, 0, 1, 10, 2, 1, 1))
    assert asked[20:28].hex(" ") == "c0 01 01 f6 00 00 00 01"  # ports 49153 and 502, sequence 1
    assert answered[20:32].hex(" ") == "01 f6 c0 01 00 00 00 01 00 00 00 0d"  # acknowledges 12 bytes
    assert asked[40:].hex(" ") == "00 07 00 00 00 06 01 03 00 6b 00 03"  # transaction 7, unit 1
    assert answered[40:].hex(" ") == "00 07 00 00 00 09 01 03 06 02 2b 00 00 00 64"  # the same transaction
    assert maker.make("tcp:1", ASK)[24:32].hex(" ") == "00 00 00 0d 00 00 00 10"
    for packet in (asked, answered):
        assert ones_complement_sum(packet[:20]) == 0xFFFF
        pseudo = packet[12:20] + struct.pack("!HH", 6, len(packet) - 20)
        assert ones_complement_sum(pseudo + packet[20:]) == 0xFFFF


def ones_complement_sum(data: bytes) -> int:
    """True if the sum of all words is all ones, as with a correct checksum (RFC 1071)."""
    total = sum(data[0::2]) * 256 + sum(data[1::2])
    while total > 0xFFFF:
        total = (total & 0xFFFF) + (total >> 16)
    return total


def test_each_client_has_its_connection_to_each_unit() -> None:
    maker = PacketMaker(0)

    def ends(sender: str, message: ModbusMessage) -> tuple[bytes, bytes]:
        packet = maker.make(sender, message)
        return packet[12:16] + packet[20:22], packet[16:20] + packet[22:24]

    first = ends("a", ModbusRequest(1, b"\x07", 1))
    second = ends("b", ModbusRequest(1, b"\x07", 2))
    third = ends("a", ModbusRequest(2, b"\x11", 3))
    assert len({first, second, third}) == 3
    assert ends("unit 2", ModbusResponse(2, b"\x11\x00", 9)) == third[::-1]
    assert ends("unit 1", ModbusResponse(1, b"\x87\x01", 9)) == first[::-1]
    assert ends("unit 1", ModbusResponse(1, b"\x07\x00", 9)) == second[::-1]


def test_response_as_another_unit_still_finds_its_request() -> None:
    maker = PacketMaker(0)
    maker.make("a", ModbusRequest(1, b"\x07", 5))
    answer = maker.make("drive", ModbusResponse(255, b"\x07\x00", 1))
    assert answer[40:].hex(" ") == "00 05 00 00 00 03 ff 07 00"


def test_response_without_a_request_has_a_packet_all_the_same() -> None:
    entry = modbus(ANSWER, "drive")
    assert read(written(entry)) == [entry]


@given(st.binary(max_size=80))
def test_no_packet_is_a_fault_of_ours(packet: bytes) -> None:
    list(messages_in(packet))
    list(messages_in(b"\x45" + packet[:8] + b"\x06" + packet[8:]))


FILE = written(*ENTRIES)


@given(st.integers(0, len(FILE) - 1), st.binary(min_size=1, max_size=4))
def test_damaged_file_is_no_fault_of_ours(at: int, patch: bytes) -> None:
    for data in (FILE[:at], FILE[:at] + patch + FILE[at + len(patch) :], patch + FILE):
        with contextlib.suppress(RigError):
            read(data)


@pytest.mark.parametrize("data", [b"", b"hello, world", b"\x0a\x0d\x0d\x0a" + bytes(20)])
def test_what_is_no_capture_is_said_to_be_none(data: bytes) -> None:
    with pytest.raises(RigError, match="damaged, or not a pcapng file"):
        read(data)


PDUS = st.binary(min_size=1, max_size=253)
MODBUS = st.builds(ModbusRequest, st.integers(0, 255), PDUS, st.integers(0, 0xFFFF_FFFF)) | st.builds(
    ModbusResponse, st.integers(0, 255), PDUS, st.integers(0, 0xFFFF_FFFF)
)


@given(st.lists(st.tuples(MODBUS, st.sampled_from(["a", "b", "drive"])), max_size=12))
def test_every_modbus_message_comes_back(sent: list[tuple[ModbusMessage, str]]) -> None:
    entries = [modbus(message, sender, number) for number, (message, sender) in enumerate(sent)]
    assert read(written(*entries)) == entries


def test_a_cut_file_is_read_as_far_as_it_goes() -> None:
    odd = Oddities()
    assert list(pcapng.read(io.BytesIO(FILE[:-5]), odd)) == ENTRIES[:-1]
    assert [oddity.what for oddity in odd] == ["the file is cut off"]


SECTION = "0a0d0d0a 1c000000 4d3c2b1a 01000000 ffffffffffffffff 1c000000"
CAN_INTERFACE = "01000000 14000000 e3000000 00000000 14000000"


@pytest.mark.parametrize(
    ("block", "reason"),
    [
        ("06000000 ffffffff", "the block at byte 48 claims to have 4294967295 bytes"),
        ("06000000 08000000", "the block at byte 48 claims to have 8 bytes"),
        ("06000000 0d000000", "the block at byte 48 claims to have 13 bytes"),
        ("05000000 10000000 00000000 14000000", "ends with another length"),
        ("06000000 24000000 00000000 00000000 00000000 ffffffff ffffffff 00000000 24000000", "a packet claims to have"),
        ("06000000 24000000 07000000 00000000 00000000 00000000 00000000 00000000 24000000", "a packet of interface 7"),
        ("01000000 18000000 e3000000 00000000 0200ff00 18000000", "an option claims to have 255 bytes"),
    ],
)  # fmt: skip
def test_a_block_with_a_lying_length_is_refused_with_its_place(block: str, reason: str) -> None:
    with pytest.raises(UsageError, match="damaged") as refused:
        read(bytes.fromhex(SECTION + CAN_INTERFACE + block))
    assert reason in refused.value.what


def test_sections_of_both_byte_orders_and_all_kinds_of_packets_are_read() -> None:
    """A section of a big-endian host with a simple packet and an obsolete one follows another section."""
    big = "0a0d0d0a 0000001c 1a2b3c4d 00010000 ffffffffffffffff 0000001c"
    interface = "00000001 00000014 00e30000 00000000 00000014"
    simple = "00000003 00000018 00000008 00000123 00000000 00000018"
    old = "00000002 00000028 0000 0000 00000000 0016e360 00000008 00000008 40000124 04000000 00000028"
    found = read(bytes.fromhex(SECTION + CAN_INTERFACE + big + interface + simple + old))
    assert [(entry.time_ns, entry.bus, can_codec.decode(entry.data)) for entry in found] == [
        (0, "interface0", CanFrame(0x123)),
        (1_500_000_000, "interface0", CanFrame(0x124, is_remote=True, remote_length=4)),
    ]
