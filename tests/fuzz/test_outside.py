# ruff: noqa: E501  rows of seeds are tables
"""Corrupted bytes from outside, at every decoder and every listener, have no effect but the specified one.

Each decoder returns a value or raises ValueError.  Each listener continues: its loop reports no exception, no name
stays taken, and a client that joins afterwards is served.  All installed kinds of buses are covered.  The inputs are
the same each time; `make fuzz` takes a million of them, divided among all targets of this folder.
"""

import asyncio
import io
import json
import random
import struct
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import pytest
from arp_user_port import PortBench, frame
from ip_line import CALLER, CONTROLLER, Peer
from patience import PATIENCE_S
from sendable import GOOD
from spoiling import spoilt
from strangers import Stranger, bus_of, hello, hub_kinds, hub_of, kind_names

from fieldrig.clock import MS
from fieldrig.control.bus_questions import answers_of_bus
from fieldrig.control.messages import _answer
from fieldrig.errors import UsageError
from fieldrig.hub.wire import Kind, Records, pack
from fieldrig.outside.untrusted import read_json, typed
from fieldrig.traces.trace import is_batch
from fieldrig.traces.trace_jsonl import read as read_jsonl
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.lawicel import decode as decode_lawicel
from fieldrig_bus.can.udp import from_wire, to_wire
from fieldrig_bus.ip.socks import Handshake
from fieldrig_bus.modbus.framing import LineTiming
from fieldrig_bus.modbus.framing_ascii import AsciiFramer, ascii_frame
from fieldrig_bus.modbus.framing_mbap import MbapFramer, tcp_frame
from fieldrig_bus.modbus.framing_rtu import RtuFramer, rtu_frame
from fieldrig_bus.ring.pam import cycle_wire as pam_wire
from fieldrig_bus.ring.pam.message import Cycle as PamCycle
from fieldrig_bus.ring.pam.star_bus import NodeRack
from fieldrig_bus.ring.sercos.cycle_wire import decode_spread, encode_spread
from fieldrig_bus.ring.sercos.message import Cycle
from fieldrig_bus.ring.transport.shm import _are
from fieldrig_bus.ring.transport.wire import decode_back, encode_back
from fieldrig_bus.ring.transport.zenoh import _stations_of
from fieldrig_bus.traces import candump, pcapng
from fieldrig_bus.traces.ppp_frames import PppFinder
from fieldrig_devices.ip import icmp
from fieldrig_devices.ip.checksum import checksum
from fieldrig_devices.ip.ipv4 import pseudo_header
from fieldrig_devices.ip.tcp.segment import Segment

pytestmark = pytest.mark.system

SEED = 2026
# Decoders


def _fed(framer: Any, data: bytes) -> None:
    framer.feed(0, data)
    framer.take(1000 * MS)


def _all_records(data: bytes) -> None:
    for _ in Records().feed(data):
        pass


TIMING = LineTiming("rtu", 9600, 11)
SPREAD = encode_spread(1, 2, [(Cycle(3, b"\xff\x04", b"\xff\x01"), ("a", "b")), (Cycle(3, b"", b""), ("c",))], b"", 3)
PAM_SPREAD = pam_wire.encode_spread(1, 2, [(PamCycle(3, ((17, b"\x02"),)), ("a",)), (PamCycle(3, ()), ("c",))], b"", 3)
PAM_RACK = NodeRack("ring0", cast(Any, None))
LINE = b'{"time_ns":1,"bus":"can0","family":"can","sender":"io","data":"23010000020501"}\n'
JSON = [b'{"bus":"wires","member":"io","proof":"00"}', b"[[385,2047],\"own\"]", b'{"keys":["a","b"]}',
        b'{"fault":{"what":"drop","count":1}}', b"[1,2.5,-3e5,true,false,null,\"\\u00e4\"]"]  # fmt: skip
REQUEST = bytes.fromhex("0300010002")
CANDUMP = b"(1700000000.000000) can0 123#0102\n(1700000000.000001) can0 12345678##1AABB\n(1.0) can0 123#R4\n"


# An echo, a SYN and a datagram of Linux 6.1.
IP = [bytes.fromhex("450000241beb40004001d893bec86465bec864640800b64435aa00010001020304050607"),
      bytes.fromhex("4500003c306740004006c3fabec86465bec86464c9f60050182fce6900000000a002faf08e070000020405b40402080a276ea05c000000000103030a"),
      bytes.fromhex("450000219a794000401159f8bec86465bec8646481ca0035000df3a768656c6c6f")]  # fmt: skip


PPP = bytes.fromhex(
    "7eff7d23c0217d217d217d207d387d227d267d207d207d207d207d237d24c0237d257d267d21713f747d277d227d287d2244f67e"
)


def _given(data: bytes) -> None:
    """Give a stack the packet, and once more with right checksums, so that all fields are looked at."""
    peer = Peer()
    peer.stack.receive(0, data)
    if len(data) >= 20:
        peer.packet(data[9], data[20:])
        with suppress(ValueError):
            peer.give(Segment.decode(_with_checksum(data[20:]), CALLER, CONTROLLER))
    peer.wait(1000)


def _with_checksum(segment: bytes) -> bytes:
    """Return the bytes as a segment with the right checksum."""
    segment = segment[:16] + bytes(2) + segment[18:]
    covered = pseudo_header(CALLER, CONTROLLER, 6, len(segment)) + segment
    return segment[:16] + checksum(covered).to_bytes(2, "big") + segment[18:]


def decoders() -> dict[str, tuple[Callable[[bytes], Any], list[bytes]]]:
    found: dict[str, tuple[Callable[[bytes], Any], list[bytes]]] = {
        "read_json": (read_json, JSON),
        "records": (_all_records, [hello("x"), pack(Kind.LISTEN, 5, b"null")]),
        "udp": (from_wire, [to_wire(CanFrame(0x123, b"12"), 1.0), to_wire(CanFrame(1, bytes(64), is_fd=True), 1.0)]),
        "lawicel": (decode_lawicel, [b"t1232AABB", b"T000001230", b"r1234", b"R1234567F8"]),
        "mbap": (lambda data: MbapFramer().feed(data), [tcp_frame(1, 1, REQUEST)]),
        "rtu": (lambda data: _fed(RtuFramer(TIMING), data), [rtu_frame(1, REQUEST)]),
        "ascii": (lambda data: _fed(AsciiFramer(TIMING), data), [ascii_frame(1, REQUEST)]),
        "spread": (decode_spread, [SPREAD]),
        "spread of a PAM": (PAM_RACK.read, [PAM_SPREAD]),
        "back": (decode_back, [encode_back(1, 2, [(0, b"\x05\x01"), (1, b"\x06")])]),
        "stations": (lambda data: _stations_of(data.decode()), [b"a=1,2;b=observer;c="]),
        "stations of shm": (
            lambda data: _are(typed(read_json(data), list)),  # the caller lets nothing but arrays through
            [b'[["a",[1,2]],["b",null]]'],
        ),
        "jsonl": (lambda data: list(read_jsonl(io.BytesIO(data))), [LINE, LINE * 2]),
        "candump": (lambda data: list(candump.read(io.BytesIO(data))), [CANDUMP]),
        "ip": (_given, IP),
        "tcp": (lambda data: Segment.decode(data, CALLER, CONTROLLER), [IP[1][20:], IP[2][20:]]),
        "socks": (lambda data: Handshake().feed(data), [bytes.fromhex("05020001 05010001bec864640015")]),
        "icmp": (icmp.answer, [IP[0][20:]]),
        "batch": (lambda data: is_batch(read_json(data)), [b'{"family":"can","process":"a","first":0,"epoch_ns":1,"entries":[[1,"a","00"]]}']),
    }  # fmt: skip
    for kind in kind_names():
        bus = bus_of(kind)
        seeds = [bus.encode(message) for sort in bus.messages for message in GOOD.get(sort, [])]
        found[kind] = (_decode_and_show(bus), [seed[:300] for seed in seeds])
    return found


def _decode_and_show(bus: Any) -> Callable[[bytes], None]:
    """Decode the bytes, then encode and show the result."""

    def look(data: bytes) -> None:
        message = bus.decode(data)
        assert bus.decode(bus.encode(message)) == message
        bus.show(message)

    return look


DECODERS = decoders()


def _pcapng() -> bytes:
    file = io.BytesIO()
    pcapng.write(read_jsonl(io.BytesIO(LINE * 3)), file, 0)
    return file.getvalue()


DECODERS["ppp frames"] = (lambda data: PppFinder().feed("a", data), [PPP])
DECODERS["pcapng"] = (lambda data: list(pcapng.read(io.BytesIO(data))), [_pcapng()])


@pytest.mark.parametrize("name", list(DECODERS))
def test_a_decoder_gives_a_value_or_a_value_error(name: str, inputs_a_target: int) -> None:
    decode, seeds = DECODERS[name]
    chance = random.Random(f"{SEED}/{name}")
    for _ in range(inputs_a_target):
        data = spoilt(chance, seeds)
        try:
            decode(data)
        except (ValueError, UsageError):
            continue
        except Exception as fault:
            raise AssertionError(f"{name}: {data.hex()}: {fault!r}") from fault


# Listeners


class Line:
    """A transport that keeps nothing."""

    def __init__(self) -> None:
        self.is_over = False

    def write(self, data: bytes) -> None:
        """Drop the text."""

    def abort(self) -> None:
        self.is_over = True

    def set_write_buffer_limits(self, high: int) -> None:
        """There is no buffer."""

    def get_extra_info(self, name: str) -> None:
        """A Unix socket has no peer."""


@pytest.mark.parametrize("kind", hub_kinds())
def test_an_attach_port_goes_on(kind: str, tmp_path: Path, inputs_a_target: int) -> None:
    chance = random.Random(f"{SEED}/attach/{kind}")

    async def scene() -> None:
        async with hub_of(kind, tmp_path) as hub:
            bus, server = hub.bus, hub._server
            assert server is not None
            messages = [pack(Kind.MESSAGE, 0, bus.encode(item)) for sort in bus.messages for item in GOOD.get(sort, [])]
            interests = (
                b"null",
                b"[]",
                b"[1]",
                b'["own"]',
                b'["data"]',
                b'["a"]',
                b"[[1,2]]",
                b'["master"]',
                b'[["drive",3]]',
            )
            seeds = [
                *(message for message in messages if len(message) < 300),
                *(pack(Kind.LISTEN, 0, interest) for interest in interests),
            ]
            for number in range(inputs_a_target):
                stream, line = server._stream(None), Line()
                stream.connection_made(line)
                if chance.random() < 0.9:
                    stream.data_received(hello(f"m{number % 7}"))
                for _ in range(3):
                    if not line.is_over:
                        stream.data_received(spoilt(chance, seeds))
                stream.connection_lost(None)
                if number % 64 == 0:
                    await asyncio.sleep(0)
            assert hub._members.keys() <= {name for name in hub._members if ":" in name}  # only its ports are left
            member = await Stranger.at(tmp_path / "bus0.sock")
            member.say(hello("io"))
            assert (await member.heard())[0] == Kind.CHALLENGE
            assert (await member.heard())[0] == Kind.HELLO
            member.close()

    asyncio.run(scene())


BUSY_LINE: dict[str, Any] = {
    "outgoing": [{"number": "1", "dial": "127.0.0.1:1"}], "faults": [{"what": "busy", "line": "outside 1"}],
}  # fmt: skip
"""A number that ends each call at once."""
PORTS: dict[str, tuple[str, dict[str, Any], list[bytes]]] = {
    "socketcand": (
        "can.hub", {"socketcand": "ADDRESS", "slcan": None, "bitrate": None},
        [b"< open bus0 >", b"< rawmode >", b"< bcmmode >", b"< send 123 2 11 22 >", b"< add 0 100000 123 1 55 >",
         b"< subscribe 0 0 123 >", b"< filter 0 0 123 1 ff >", b"< echo >", b"< statistics 1000 >", b"< delete 123 >",
         b"< open bus0 >< rawmode >< send 12345678 8 1 2 3 4 5 6 7 8 >", b"< muxfilter 0 0 123 2 ff 01 >"],
    ),
    "lawicel": (
        "can.hub", {"socketcand": None, "slcan": {"listen": "ADDRESS"}, "bitrate": None},
        [b"S6\rO\r", b"t1232AABB\r", b"T000001238" + b"00" * 8 + b"\r", b"V\r", b"N\r", b"F\r", b"Z1\r", b"M00000000\r",
         b"C\r", b"L\r", b"X1\r", b"s031C\r", b"r1230\r", b"W0\r", b"A\r", b"P\r"],
    ),
    "modbus.tcp": ("modbus.tcp", {"listen": "ADDRESS"}, [tcp_frame(1, 1, REQUEST), tcp_frame(2, 0, b"\x2b\x0e\x01\x00")]),
    "modbus.rtu": ("modbus.rtu", {"listen": "ADDRESS"}, [rtu_frame(1, REQUEST), rtu_frame(0, b"\x06\x00\x01\x00\x02")]),
    "modbus.ascii": ("modbus.ascii", {"listen": "ADDRESS"}, [ascii_frame(1, REQUEST), ascii_frame(0, b"\x06\x00\x01\x00\x02")]),
    "serial.tcp": ("serial.tcp", {"listen": "ADDRESS", "paced": False}, [b"hello\r\n", bytes(range(256))]),
    "serial.rfc2217": (
        "serial.rfc2217", {"listen": "ADDRESS", "paced": False},
        [b"\xff\xfb\x2c", b"\xff\xfa\x2c\x01\x00\x00\x25\x80\xff\xf0", b"\xff\xfa\x2c\x02\x08\xff\xf0",
         b"\xff\xfa\x2c\x03\x01\xff\xf0", b"\xff\xfa\x2c\x04\x01\xff\xf0", b"\xff\xfa\x2c\x05\x08\xff\xf0", b"data\xff\xff",
         b"\xff\xfa\x2c\x0a\xff\xff\xff\xf0", b"\xff\xfd\x03", b"\xff\xfa\x2c\x0c\x03\xff\xf0", b"\xff\xf3"],
    ),
    "telephone": (
        "telephone.exchange", {**BUSY_LINE, "incoming": [{"listen": "ADDRESS", "number": "1"}]},
        [b"hello", bytes(range(256))],
    ),
    "telephone, Telnet": (
        "telephone.exchange",
        {**BUSY_LINE, "incoming": [{"listen": "ADDRESS", "number": "1", "telnet": True}]},
        [b"hello", b"\xff\xfd\x00", b"\xff\xfb\x01", b"data\xff\xff", b"\xff\xfa\x18\x00\xff\xf0"],
    ),
}  # fmt: skip
A_CONNECTION = 25
"""Inputs on one connection."""


def _with_address(settings: dict[str, Any], address: str) -> dict[str, Any]:
    return json.loads(json.dumps(settings).replace("ADDRESS", address))  # type: ignore[no-any-return]


@pytest.mark.parametrize("name", list(PORTS))
def test_a_way_in_for_outsiders_goes_on(name: str, tmp_path: Path, inputs_a_target: int, free_tcp: int) -> None:
    kind, settings, seeds = PORTS[name]
    chance = random.Random(f"{SEED}/port/{name}")

    async def swallow(reader: asyncio.StreamReader) -> None:
        with suppress(ConnectionError):
            while await reader.read(65536):
                pass

    async def scene() -> None:
        async with hub_of(kind, tmp_path, **_with_address(settings, f"127.0.0.1:{free_tcp}")) as hub:
            members = set(hub._members)
            for first in range(0, inputs_a_target, A_CONNECTION):
                reader, writer = await asyncio.open_connection("127.0.0.1", free_tcp)
                swallowing = asyncio.get_running_loop().create_task(swallow(reader))
                with suppress(ConnectionError):
                    for _ in range(first, min(first + A_CONNECTION, inputs_a_target)):
                        writer.write(spoilt(chance, seeds))
                    await writer.drain()
                    if chance.random() < 0.5:
                        writer.write_eof()
                        await asyncio.sleep(0)
                writer.close()
                with suppress(ConnectionError):
                    await writer.wait_closed()
                await swallowing
            async with asyncio.timeout(PATIENCE_S):
                while set(hub._members) - members:  # a client that is gone has left the bus
                    await asyncio.sleep(0.001)
            reader, writer = await asyncio.open_connection("127.0.0.1", free_tcp)
            writer.close()
            with suppress(ConnectionError):
                await writer.wait_closed()

    asyncio.run(scene())


class Question:
    """A query as Zenoh hands it over."""

    def __init__(self, verb: str, payload: bytes) -> None:
        self.key_expr = f"fieldrig/lab/bus/bus0/{verb}"
        self.payload = self
        self._payload = payload
        self.answers = 0

    def to_bytes(self) -> bytes:
        return self._payload

    def __enter__(self) -> "Question":
        return self

    def __exit__(self, *_: object) -> None:
        """Done."""

    def reply(self, _key: str, data: str) -> None:
        json.loads(data)
        self.answers += 1

    def reply_err(self, data: str) -> None:
        assert json.loads(data)["what"]
        self.answers += 1


@pytest.mark.share(0.1)  # a fault that is refused in words costs as much as ten frames
@pytest.mark.parametrize("kind", hub_kinds())
def test_a_question_has_one_answer(kind: str, tmp_path: Path, inputs_a_target: int) -> None:
    chance = random.Random(f"{SEED}/question/{kind}")
    seeds = [*JSON, b'{"number":1}', b"null", b'{"fault":{"what":"drop","node":"io","identifier":"0x123","duration_ms":5}}',
             b'{"fault":{"what":"break","after":"master"}}', b'{"fault":{"what":"replace","data":"01 02"}}']  # fmt: skip

    async def scene() -> None:
        async with hub_of(kind, tmp_path) as hub:
            answer = answers_of_bus(hub)
            for _ in range(inputs_a_target):
                question: Any = Question(
                    chance.choice(("status", "faults", "add_fault", "clear_fault", "x")), spoilt(chance, seeds)
                )
                await _answer(question, "fieldrig/lab/bus/bus0", answer, None)
                assert question.answers == 1

    asyncio.run(scene())


@pytest.mark.share(0.25)
def test_the_user_port_of_an_arp_card_goes_on(inputs_a_target: int) -> None:
    chance = random.Random(f"{SEED}/user port")
    bench = PortBench()
    seeds = [frame(bytes((1, 1, 1, command)) + data) for command, data in _commands()]
    for number in range(inputs_a_target):
        bench.user.deliver(spoilt(chance, seeds))
        if number % 16 == 0:
            bench.run_for(1)
            bench.user.take()
    bench.user.deliver(b"~~")
    bench.run_for(3_000)
    bench.user.take()
    status, identity = bench.ask(0x01)
    assert status == 0
    assert identity


def _commands() -> Iterator[tuple[int, bytes]]:
    for command in (*range(0x01, 0x08), *range(0x10, 0x18), *range(0x20, 0x28), *range(0x30, 0x38), *range(0x40, 0x50)):
        yield command, b""
        yield command, struct.pack("<II", 16, 0)
        yield command, struct.pack("<HH", 1, 2) + b"NAME"
