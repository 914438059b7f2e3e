"""Messages of every type that a bus may carry: some that a member may send, and some that no member can send.

Each row is from a standard: ISO 11898-1 (identifiers of 11 and 29 bits, 0 to 8 bytes, the lengths of FD), the Modbus
application protocol V1.1b3, chapter 4.1 (a PDU has 1 to 253 bytes), TIA-232 formats; wires carry finite numbers.
"""

from ipaddress import IPv4Address
from math import inf, nan
from typing import Any

from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BitRate, BusState, CanControl, CanError, CanState, ErrorKind, FaultNote
from fieldrig_bus.dualport.message import Words
from fieldrig_bus.ip.message import (
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
)
from fieldrig_bus.modbus.message import ClientConnected, LineState, ModbusRequest, ModbusResponse
from fieldrig_bus.opcua.message import (
    Browse,
    Call,
    Find,
    Kind,
    Node,
    Nodes,
    Outcome,
    Outcomes,
    Read,
    Status,
    Write,
)  # fmt: skip
from fieldrig_bus.opcua.message import Offer as OpcOffer
from fieldrig_bus.ring.pam.message import Cycle as PamCycle
from fieldrig_bus.ring.pam.message import Frames, Reports
from fieldrig_bus.ring.sercos.message import Answers, Cycle, Mdt, Mst
from fieldrig_bus.serial.message import Break, ControlLines, Format
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.tcp.message import Close, Connect, Connected, Data, Listen, Listening, Taken, Unlisten, Unreached
from fieldrig_bus.tcp.message import Ended as TcpEnded
from fieldrig_bus.telephone.message import Carrier, Dial, Heard, Hook, Offer, Ready, Ring, Tone
from fieldrig_bus.telephone.modulation import Modulation, everything
from fieldrig_bus.wires import Motion, Signal

_any: Any = lambda value: value  # noqa: E731  what mypy would find at once is what is sent here


HERE, THERE = IPv4Address("190.200.100.100"), IPv4Address("190.200.100.101")

GOOD: dict[type, list[Any]] = {
    CanFrame: [
        CanFrame(0), CanFrame(0x7FF, bytes(8)), CanFrame(0x1FFF_FFFF, b"1", is_extended=True),
        CanFrame(1, is_remote=True, remote_length=8), CanFrame(1, bytes(64), is_fd=True, is_bit_rate_switched=True),
    ],
    CanControl: [CanControl(), CanControl(True, False, True)],
    BitRate: [BitRate(125_000)],
    ModbusRequest: [ModbusRequest(255, bytes(253)), ModbusRequest(0, b"\x03", 0xFFFF_FFFF, LineState(1, 2, True))],
    ModbusResponse: [ModbusResponse(1, b"\x83\x02")],
    ClientConnected: [ClientConnected("127.0.0.1"), ClientConnected("::1")],
    ControlLines: [ControlLines(), ControlLines(False, False, True, True)],
    Format: [Format(), Format(115_200, 7, "E", 2)],
    Break: [Break(0), Break(250)],
    Words: [Words(0, ()), Words(2047, (0xFFFF,)), Words(0, (0,) * 2048)],
    Mst: [Mst(0, b"\xff\x04")],
    Mdt: [Mdt(b""), Mdt(b"\xff\x01\x02")],
    bytes: [b"", b"\x05\x00\x00"],
    Frames: [Frames(0, ()), Frames(1, ((0, b"\x01"), (255, bytes(255)), (0x10F, b"x")))],
    OpcOffer: [OpcOffer("plc", "a controller", 0)],
    Browse: [Browse("plc", 1, ""), Browse("plc", 2, "PLC_PRG", 100)],
    Find: [Find("plc", 1, "PLC_PRG.n")],
    Read: [Read("plc", 1, ("a", "b")), Read("plc", 1, ())],
    Write: [Write("plc", 1, "a", True), Write("plc", 1, "a", [1.5, inf]), Write("plc", 1, "a", "text")],
    Call: [Call("plc", 1, "start")],
    Nodes: [Nodes(1, (Node("a", "", "a", Kind.VARIABLE, "INT", 3, True, choices=(("red", 0),)),), False),
            Nodes(1, (Node("b", "", "b", low=0, high=10),))],
    Outcomes: [Outcomes(1, (Outcome(Status.GOOD, 1.5), Outcome(Status.REFUSED, None, "why")))],
    Offered: [Offered(()), Offered((1, 65_535))],
    Opened: [Opened("plc", 0, 80), Opened("\u00e4", 0xFFFF_FFFF, 65_535)],
    Portion: [Portion("plc", 1, False, b"GET"), Portion("", 1, True, bytes(8192))],
    Consumed: [Consumed("plc", 1, True, 65_536)],
    Ended: [Ended("plc", 1, False)],
    Closed: [Closed("plc", 1, True, "aborted")],
    KernelOffered: [KernelOffered()],
    LinkUp: [LinkUp("plc", HERE, THERE, 1500, (21, 80)), LinkUp("", HERE, THERE, 65_535, ())],
    LinkDown: [LinkDown("plc", False, "the link is gone"), LinkDown("plc", True, "")],
    IpPacket: [IpPacket("plc", False, b"\x45"), IpPacket("plc", True, bytes(65_535))],
    Hook: [Hook(True), Hook(False)],
    Dial: [Dial("0"), Dial("0*#ABCD" * 9)],
    Offer: [Offer(()), Offer(everything(), 2, 9600), Offer((Modulation("V21", 300, 300),), 1)],
    Carrier: [Carrier(0), Carrier(33_600, True, False)],
    Ready: [Ready(True), Ready(False)],
    Connected: [Connected(1, "http", "127.0.0.1", "127.0.0.1"), Connected(2, "", "::1", "::1", 1)],
    Data: [Data(1, b"GET"), Data(0xFFFF_FFFF, bytes(16_384))],
    Taken: [Taken(1, 1)],
    TcpEnded: [TcpEnded(1), TcpEnded(1, True)],
    Close: [Close(1), Close(2, "clients that did not read")],
    Listen: [Listen(1)],
    Listening: [Listening(1, 0), Listening(1, 65_535)],
    Unlisten: [Unlisten(1)],
    Connect: [Connect(1, 1), Connect(1, 65_535)],
    Unreached: [Unreached(1)],
    Signal: [Signal("pump.run", True), Signal("tank.level", 1.5, "m"), Signal("", -(1 << 63)),
             Motion("encoder", 7, "count", -5, 1.5, 0.0), PulseTrain("p", 0, frequency=50_000, count=7),
             Pwm("p", 12.5, frequency=65_000)],
}  # fmt: skip

BAD: dict[type, list[Any]] = {
    Words: [Words(2047, (0, 0)), Words(2048, (0,)), Words(-1, (0,)), Words(0, (0x1_0000,)), Words(0, (_any(1.0),))],
    CanFrame: [],  # a wrong one cannot be made: tests/bus/can/test_frame.py
    CanControl: [CanControl(_any(1)), CanControl(None, _any("no")), CanControl(recover=_any(None))],
    BitRate: [BitRate(0), BitRate(-5), BitRate(1 << 40), BitRate(_any(125e3)), BitRate(_any("125000"))],
    # These are a controller's to say, and the bus's, never a member's.
    CanError: [CanError(ErrorKind.BIT, next(iter(Place)), 1, 1, True, False, 8, 0)],
    BusState: [BusState(CanState.ACTIVE, 0, 0)],
    FaultNote: [FaultNote(1, "dropped")],
    OpcOffer: [OpcOffer(_any(1), "", 0), OpcOffer("plc", _any(None), 0), OpcOffer("plc", "", _any("0")),
               OpcOffer("p" * 4_097, "", 0)],
    Connected: [Connected(0, "http", "127.0.0.1", "127.0.0.1"), Connected(1, "http", "localhost", "127.0.0.1"),
                Connected(1, "h" * 33, "127.0.0.1", "127.0.0.1"), Connected(1, "h\n", "127.0.0.1", "127.0.0.1"),
                Connected(1, _any(b"http"), "127.0.0.1", "127.0.0.1"), Connected(1, "", "::1", "::1", -1)],
    Data: [Data(1, b""), Data(1, bytes(16_385)), Data(_any("1"), b"x"), Data(1, _any("x")), Data(1 << 32, b"x")],
    Taken: [Taken(1, 0), Taken(1, _any(1.0))],
    TcpEnded: [TcpEnded(0), TcpEnded(1, _any(1))],
    Close: [Close(_any(None)), Close(1, "Unread"), Close(1, _any(None)), Close(1, "a" * 65)],
    Listen: [Listen(-1)],
    Listening: [Listening(1, 65_536), Listening(1, -1)],
    Unlisten: [Unlisten(_any(True))],
    Connect: [Connect(1, 0), Connect(1, 65_536), Connect(0, 20), Connect(1, _any("20"))],
    Unreached: [Unreached(0), Unreached(_any(None))],
    Browse: [Browse("plc", _any("1"), ""), Browse("plc", 1, _any(None)), Browse("plc", 1, "", _any(1.5))],
    Find: [Find("plc", 1, _any(b"a")), Find("plc", 1, "a" * 4_097)],
    Read: [Read("plc", 1, _any((1,))), Read("plc", 1, ("x",) * 201), Read("plc", 1, _any("ab"))],
    Write: [Write("plc", 1, "a", _any(None)), Write("plc", 1, "a", _any({})), Write("plc", 1, "a", _any([None]))],
    Call: [Call("plc", _any(None), "start")],
    Nodes: [Nodes(1, (Node("x", "", "x"),) * 101), Nodes(1, (Node(_any(1), "", "x"),)), Nodes(1, _any(None))],
    Outcomes: [Outcomes(1, (Outcome(Status.GOOD, _any({})),)), Outcomes(_any(True), ()), Outcomes(1, _any(("x",)))],
    ModbusRequest: [
        ModbusRequest(256, b"\x03"), ModbusRequest(-1, b"\x03"), ModbusRequest(1, b""), ModbusRequest(1, bytes(254)),
        ModbusRequest(1, b"\x03", -1), ModbusRequest(1, b"\x03", 1 << 32), ModbusRequest(_any("1"), b"\x03"),
        ModbusRequest(1, _any("03")), ModbusRequest(1, _any(bytearray(b"\x03"))), ModbusRequest(1, b"\x03", _any(1.0)),
        ModbusRequest(1, b"\x03", 1, _any("line")), ModbusRequest(_any(True), b"\x03"),
    ],
    ModbusResponse: [
        ModbusResponse(256, b"\x03"), ModbusResponse(1, b""), ModbusResponse(1, bytes(254)),
        ModbusResponse(1, _any(None)), ModbusResponse(1, b"\x03", _any("1")),
    ],
    Offered: [Offered((0,)), Offered((65_536,)), Offered(_any([80])), Offered(_any(("80",))), Offered((80,) * 101)],
    Opened: [Opened("plc", 1, 0), Opened("plc", -1, 80), Opened("p" * 256, 1, 80), Opened(_any(1), 1, 80),
             Opened("plc", _any(True), 80), Opened("\ud800", 1, 80)],
    Portion: [Portion("plc", 1, False, b""), Portion("plc", 1, False, bytes(8193)), Portion("plc", 1, _any(1), b"x"),
              Portion("plc", 1, False, _any("x")), Portion("plc", 1 << 32, False, b"x")],
    Consumed: [Consumed("plc", 1, False, 0), Consumed("plc", 1, False, 65_537), Consumed("plc", 1, _any(None), 5)],
    Ended: [Ended("plc", 1, _any("no")), Ended(_any(None), 1, False)],
    Closed: [Closed("plc", 1, False, "w" * 256), Closed("plc", 1, False, _any(b"why"))],
    KernelOffered: [],
    LinkUp: [LinkUp("plc", HERE, THERE, 0, ()), LinkUp("plc", HERE, THERE, 1500, (0,)),
             LinkUp("plc", _any("190.200.100.100"), THERE, 1500, ()), LinkUp(_any(1), HERE, THERE, 1500, ())],
    LinkDown: [LinkDown("plc", _any(0), ""), LinkDown("plc", True, "w" * 256)],
    IpPacket: [IpPacket("plc", True, b""), IpPacket("plc", True, bytes(65_536)), IpPacket("plc", _any(None), b"\x45")],
    ClientConnected: [ClientConnected("somewhere"), ClientConnected(""), ClientConnected(_any(2130706433))],
    ControlLines: [ControlLines(_any(1)), ControlLines(rts=_any(None)), ControlLines(dcd=_any("on"))],
    Format: [Format(0), Format(-9600), Format(1 << 32), Format(9600, _any(9)), Format(9600, 8, _any("X")),
             Format(9600, 8, "N", _any(3)), Format(_any("9600")), Format(9600, _any("8")), Format(9600, 8, _any(b"N"))],
    Break: [Break(-1), Break(1 << 32), Break(_any(0.5)), Break(_any("1"))],
    Mst: [Mst(0, b""), Mst(-1, b"\xff\x04"), Mst(0, bytes(1 << 16)), Mst(0, _any("ff")), Mst(_any("0"), b"\xff\x04")],
    Mdt: [Mdt(bytes(1 << 16)), Mdt(_any(None)), Mdt(_any(bytearray(2)))],
    Frames: [Frames(-1, ()), Frames(0, ((0x100, b"x"),)), Frames(0, ((0x110, b"x"),)), Frames(0, ((1, b""),)),
             Frames(0, ((1, bytes(256)),)), Frames(0, ((-1, b"x"),)), Frames(_any("0"), ()), Frames(0, _any([])),
             Frames(0, ((_any("1"), b"x"),)), Frames(0, ((1, _any("x")),))],
    # The ring's own words.
    PamCycle: [PamCycle(0, ())],
    Reports: [Reports(0, (), ())],
    Cycle: [Cycle(0, b"\xff\x04", b"")],
    Answers: [Answers(0, (), True)],
    bytes: [],
    # The exchange's own words.
    Ring: [Ring(True), Ring(False, "100")],
    Heard: [Heard(Tone.DIAL)],
    Hook: [Hook(_any(1)), Hook(_any(None))],
    Dial: [Dial(""), Dial("1" * 65), Dial("0 1"), Dial("W"), Dial(_any(5)), Dial(_any(b"1"))],
    Offer: [Offer(_any([])), Offer((_any("V34"),)), Offer((Modulation("V99", 0, 0),)), Offer(everything() * 2),
            Offer((Modulation("V34", -1, 0),)), Offer((Modulation("V34", 0, 99_999),)), Offer((), 3), Offer((), 0, -1),
            Offer((Modulation(_any(None), 0, 0),))],
    Carrier: [Carrier(-1), Carrier(33_601), Carrier(_any("300")), Carrier(300, _any(1)), Carrier(300, True, _any(0))],
    Ready: [Ready(_any(1)), Ready(_any("yes"))],
    Signal: [
        Signal("level", nan), Signal("level", inf), Signal("level", -inf), Signal("level", 1 << 64),
        Signal("level", -(1 << 63) - 1), Signal("level", _any("1")), Signal("level", _any(None)), Signal(_any(5), 1),
        Signal("level", 1, _any(None)), Signal("x" * 1000, 1), Signal("\ud800", 1), Signal("level", 1, "m" * 100),
        Motion("m", nan), Motion("m", True), Motion("m", 1, "", 0, nan), Motion("m", 1, "", 0, 0.0, inf),
        Motion("m", 1, "", 1 << 70), Motion("m", 1, "", _any(0.5)), Motion("m", 1, "", 0, _any("fast")),
        PulseTrain("p", 0, count=None), PulseTrain("p", 1, frequency=5), PulseTrain("p", 0, frequency=_any(0.5)),
        Pwm("p", 101), Pwm("p", 50, frequency=0), Pwm("p", _any(True)),
    ],
}  # fmt: skip

NO_MESSAGES: list[Any] = [
    "hello",
    None,
    5,
    1.5,
    True,
    object(),
    [],
    {},
    bytearray(b"1"),
    memoryview(b"1"),
    Exception("x"),
]

BAD_INTERESTS: list[Any] = [
    "all", b"all", 5, {"a": 1}, {1}, [[1, 2, 3]], [{"a": 1}], [None], [1.5], [True], [-1], [[]], [object()],
    [1 << 40], ["\ud800"], [["drive"]], [["drive", "x"]], [["drive", 255]], [1] * 20_000,
]  # fmt: skip
