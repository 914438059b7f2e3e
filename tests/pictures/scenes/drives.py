"""Drives and their controller at work: a boot, and a drive that reads the name plate of its motor."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

from tests.pictures.recording import ROOT, Sent, recorded
from tests.pictures.timing import Bar, Lane, spans, timing

from fieldrig.clock import MS, S
from fieldrig.virtual.rig import Rig

PLATE: Final = str(ROOT / "configs" / "plates" / "sm-100-30-080.yaml")
RING: Final = {"kind": "ring.virtual"}
DRIVES: Final = {"belt": 1, "knife": 2}
BYTE_NS: Final = 11 * S // 9_600
"""A byte of the line: start bit, 8 data bits, even parity, stop bit."""
PAUSE_NS: Final = 2 * BYTE_NS
COMMANDS: Final = {
    0x42: "42h position",
    0x46: "46h counter",
    0x4A: "4Ah read data",
    0x4C: "4Ch field status",
    0x4E: "4Eh memory",
    0x50: "50h status",
    0x52: "52h type label",
    0x56: "56h serial number",
}


class Telegram(NamedTuple):
    sender: str
    start_ns: int
    end_ns: int
    data: bytes


def boot() -> str:
    """The phases of the ring, and the entries of the message logger at their instants."""
    rows: list[tuple[int, str]] = []
    codes: list[tuple[int, str]] = []

    def play(rig: Rig) -> None:
        while not rig.get("max4", "booted"):
            rig.run_until(rig.now_ns + MS)
            rows.append((rig.now_ns, f"CP{rig.get('max4', 'ring.phase')}"))
            code = str(rig.get("max4", "log.last")).split("\t")
            codes.append((rig.now_ns, code[5] if len(code) > 1 else ""))

    recorded(_ring_rig(), play)
    about = "The ring goes through its communication phases; then the boot starts and finishes."
    lanes = [Lane("ring", spans(rows, "bus"), "phase"), Lane("logger", spans(codes), "newest entry")]
    return timing(lanes, 0, rows[-1][0] + 20 * MS, "Boot of a MAx-4 with two drives", about)


def _ring_rig() -> dict[str, Any]:
    drives = {
        name: {"kind": "mc4", "ring_address": address, "motor": {"name_plate": PLATE}, "links": {"ring": "ring"}}
        for name, address in DRIVES.items()
    }
    axes = {name: {"ring_address": address} for name, address in DRIVES.items()}
    max4 = {"kind": "max4", "drives": axes, "links": {"ring": "ring"}}
    return {"time": "virtual", "buses": {"ring": RING}, "devices": {"max4": max4, **drives}}


def hiperface() -> str:
    """The first telegrams of a drive that asks the encoder of its motor for the name plate."""
    encoder = {"kind": "sm.encoder", "name_plate": PLATE, "links": {"line": "line"}}
    drive = {"kind": "mc4", "ring_address": 1, "links": {"ring": "ring", "encoder": "line"}}
    rig = {
        "time": "virtual",
        "buses": {"ring": RING, "line": {"kind": "serial.virtual", "parity": "E"}},
        "devices": {"encoder": encoder, "drive": drive},
    }
    sent = recorded(rig, lambda rig: rig.run_until(S))
    told = list(_telegrams([message for message in sent if message.bus == "line"]))
    first = next(place for place, telegram in enumerate(told) if telegram.sender == "encoder") - 1
    shown = told[first : first + 10]
    lanes = [
        Lane(name, [_bar(telegram, style) for telegram in shown if telegram.sender == name], about)
        for name, style, about in (("drive", "bus", "requests"), ("encoder", "device", "answers"))
    ]
    about = "The drive asks for type label, serial number and status, and then reads the data field of the name plate."
    start = shown[0].start_ns - 2 * MS
    return timing(lanes, start, shown[-1].end_ns + 10 * MS, "A drive reads the name plate over HIPERFACE", about)


def _telegrams(sent: Sequence[Sent]) -> Iterator[Telegram]:
    """The bytes of one sender without a pause between them."""
    found: list[Telegram] = []
    for message in sent:
        if not isinstance(message.message, bytes):
            continue
        last = found[-1] if found else None
        if last is not None and last.sender == message.sender and message.time_ns - last.end_ns < PAUSE_NS:
            found[-1] = last._replace(end_ns=message.time_ns, data=last.data + message.message)
        else:
            found.append(Telegram(message.sender, message.time_ns - BYTE_NS, message.time_ns, message.message))
    return iter(found)


def _bar(telegram: Telegram, style: str) -> Bar:
    command = telegram.data[1]
    answer = f"{len(telegram.data)} bytes" if style == "device" else COMMANDS.get(command, f"{command:02X}h")
    return Bar(telegram.start_ns, telegram.end_ns, answer, style)


PICTURES: Final[Mapping[str, Callable[[], str]]] = {"hiperface": hiperface, "max4-boot": boot}
