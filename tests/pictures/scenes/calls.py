"""A call to a MAx-4: dialling, PPP, a page by HTTP, and the end, from the trace of a rig."""

from collections import defaultdict
from collections.abc import Callable, Mapping
from itertools import groupby
from typing import Any, Final

from dialled_rig import Laptop, call, rig_of, run_until
from tests.pictures.ladder import Part, Rung, ladder
from tests.pictures.recording import Sent, recorded

from fieldrig.clock import S
from fieldrig.virtual.rig import Rig
from fieldrig_bus.telephone.message import Carrier, Dial, Hook, Ring
from fieldrig_bus.traces.ppp_frames import PppFinder
from fieldrig_devices.ip.ipv4 import Packet, Protocol
from fieldrig_devices.ip.tcp.segment import ACK, FIN, SYN, Segment
from fieldrig_devices.ppp.protocols import ProtocolNumber
from fieldrig_devices.ppp.vj import Decompressor

PARTIES: Final = ("laptop", "its modem", "modem of COM1", "MAx-4")
LAPTOP, CALLER, MACHINE, PLC = range(4)
SENDERS: Final = {"terminal_0": LAPTOP, "laptop_0": CALLER, "machine_0": MACHINE, "max4_0": PLC}
NEIGHBOUR: Final = {LAPTOP: CALLER, CALLER: LAPTOP, MACHINE: PLC, PLC: MACHINE}
PROTOCOLS: Final = {0xC021: "LCP", 0xC023: "PAP", 0x8021: "IPCP"}
# RFC 1661, 5; RFC 1334, 2.2
CODES: Final = {
    "LCP": {1: "Configure-Request", 2: "Configure-Ack", 5: "Terminate-Request", 6: "Terminate-Ack"},
    "PAP": {1: "Authenticate-Request", 2: "Authenticate-Ack"},
}
CODES_OF_IPCP: Final = {1: "Configure-Request", 2: "Configure-Ack", 3: "Configure-Nak", 4: "Configure-Reject"}


def a_call() -> str:
    """One call of `fieldrig dial`, as the rig has carried it."""
    begun: list[int] = []

    def play(rig: Rig) -> None:
        laptop = Laptop(rig)
        run_until(rig, (), lambda: laptop.is_awaited)
        begun.append(rig.now_ns)
        call(rig, [laptop])
        page = laptop.fetch("/AXES.HTM")
        run_until(rig, [laptop], lambda: page.is_complete)
        laptop.caller.hang_up(rig.now_ns)
        end_ns = rig.now_ns + 7 * S
        while rig.now_ns < end_ns and not laptop.caller.is_over:
            rig.run_until(rig.now_ns + S // 1000)
            laptop.caller.advance(rig.now_ns)

    sent = [one for one in recorded(rig_of(38_400, axes=1), play) if begun and one.time_ns > begun[0]]
    parts = [
        Part(name, [rung for _, rung in rungs]) for name, rungs in groupby(_rungs(sent, begun[0]), lambda row: row[0])
    ]
    about = "The laptop dials, the modems connect, PPP agrees, logs in and gives the address, HTTP brings a page."
    return ladder(PARTIES, parts, "A call to the controller", about)


def _rungs(sent: list[Sent], begin_ns: int) -> list[tuple[str, Rung]]:
    found: list[tuple[str, Rung]] = []
    reader = _Reader()
    for one in sent:
        sender = SENDERS.get(one.sender)
        for part, start, receiver, label in reader.read(one, sender):
            found.append((part, Rung((one.time_ns - begin_ns) / S, start, receiver, label)))
    return found


class _Reader:
    """Reads what the parties send."""

    def __init__(self) -> None:
        self._frames = PppFinder()
        self._headers: dict[str, Decompressor] = defaultdict(Decompressor)
        self._texts: dict[str, bytes] = {}
        self._part = "Dialling"

    def read(self, sent: Sent, sender: int | None) -> list[tuple[str, int, int, str]]:
        """Return part, sender, receiver and label of everything that is complete with this message."""
        if sent.bus == "telephone":
            label = _shown_on_telephone(sent.message, sender)
            ends = (MACHINE, CALLER) if sender == MACHINE else (CALLER, MACHINE)
            return [(self._part, *ends, label)] if label else []
        if not isinstance(sent.message, bytes) or sender is None:
            return []
        labels = self._commands(sent.message, sent.sender) if self._part in ("Dialling", "Hanging up") else []
        found = [(self._part, sender, NEIGHBOUR[sender], label) for label in labels if not is_echo(label, sender)]
        if sent.bus == "com1_0":
            for frame in self._frames.feed(sent.sender, sent.message):
                part, label = _shown(frame, self._headers[sent.sender])
                found += [(part, *((PLC, LAPTOP) if sender == PLC else (LAPTOP, PLC)), label)] if label else []
                self._part = part
                if label == "LCP Terminate-Ack":
                    self._part = "Hanging up"
                    self._texts.clear()
        return found

    def _commands(self, data: bytes, sender: str) -> list[str]:
        *lines, rest = (self._texts.get(sender, b"") + data).split(b"\r")
        if rest == b"+++":  # it ends without a carriage return
            lines, rest = [*lines, rest], b""
        self._texts[sender] = rest[-40:]
        shown = [line.strip(b"\n").decode("ascii", "replace") for line in lines]
        return [text for text in shown if text.isascii() and text.isprintable() and text]


def is_echo(label: str, sender: int) -> bool:
    return sender in (CALLER, MACHINE) and label.startswith(("AT", "+++"))


def _shown_on_telephone(message: Any, sender: int | None) -> str:
    match message:
        case Dial(digits=digits):
            return f"dials {digits}"
        case Ring(is_on=True):
            return "rings"
        case Carrier(bps=bps) if bps and sender == MACHINE:
            return f"carrier, {bps} bit/s"
        case Hook(is_off=False):
            return "on hook"
    return ""


def _shown(frame: bytes, headers: Decompressor) -> tuple[str, str]:
    """Return the part that a frame belongs to, and the frame in words; empty for what is not shown."""
    content = frame.removeprefix(b"\xff\x03")
    size = 1 if content[0] & 1 else 2
    protocol, payload = int.from_bytes(content[:size], "big"), content[size:]
    if protocol == ProtocolNumber.IP:
        return "IP", _shown_packet(payload)
    if protocol in (ProtocolNumber.VJ_WHOLE, ProtocolNumber.VJ_COMPRESSED):
        restored = headers.whole if protocol == ProtocolNumber.VJ_WHOLE else headers.compressed
        return "IP", _shown_packet(restored(payload))
    name = PROTOCOLS[protocol]
    codes = CODES.get(name, CODES_OF_IPCP)
    return "PPP", f"{name} {codes[payload[0]]}" if payload[0] in codes else ""


def _shown_packet(data: bytes) -> str:
    packet = Packet.decode(data)
    if packet.protocol != Protocol.TCP:
        return ""
    segment = Segment.decode(packet.payload, packet.source, packet.destination)
    if segment.data:
        first = segment.data.split(b"\r\n")[0].decode("ascii", "replace")
        return first if first.startswith(("GET", "HTTP")) else f"{len(segment.data)} bytes"
    names = [name for flag, name in ((SYN, "SYN"), (FIN, "FIN"), (ACK, "ACK")) if segment.flags & flag]
    return f"TCP {', '.join(names)}" if len(names) > 1 or names == ["SYN"] else ""


PICTURES: Final[Mapping[str, Callable[[], str]]] = {"teleservice-call": a_call}
