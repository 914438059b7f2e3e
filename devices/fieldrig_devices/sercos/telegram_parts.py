"""The telegrams of a SERCOS ring value by value: the words at their heads bit by bit, and cyclic values by their IDNs.

Source: IEC 61491 by its public facts.  A value is called by its drive and its IDN, such as `knife/S-0-0051`.
"""

import struct
from collections.abc import Iterable, Iterator, Mapping
from typing import Final, NamedTuple

from fieldrig.points.values import counted
from fieldrig.traces.parts import Part
from fieldrig_bus.ring.sercos.message import Answers
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.datum import Datum
from fieldrig_devices.sercos.idn import idn_text

_HEAD: Final = struct.Struct("<HH")


class Head(NamedTuple):
    """The word at the head of a record."""

    idn: int
    name: str
    bits: Mapping[int, str]


CONTROL: Final = Head(
    std.MASTER_CONTROL,
    "master control word",
    {
        15: "drive on", 14: "enable drive", 13: "run", 9: "operation mode", 8: "operation mode",
        5: "service element", 4: "service element", 3: "service element", 2: "last part", 1: "write",
        0: "service handshake",
    },
)  # fmt: skip
STATUS: Final = Head(
    std.DRIVE_STATUS,
    "drive status word",
    {
        15: "power", 14: "ready", 13: "class 1 error", 12: "class 2 changed", 11: "class 3 changed",
        5: "procedure command changed", 2: "service error", 1: "service busy", 0: "service handshake",
    },
)  # fmt: skip


def head_parts(drive: str, head: Head, data: bytes) -> Iterator[Part]:
    """Yield the word and the two bytes of the service channel that a record begins with."""
    if len(data) < _HEAD.size:
        return
    word, info = _HEAD.unpack_from(data)
    yield Part(f"{drive}/{idn_text(head.idn)}", head.name, word, f"{word:04X}h", head.bits)
    yield Part(f"{drive}/service", "", info, f"{info:04X}h")


def data_parts(drive: str, data: Iterable[tuple[Datum, bytes]]) -> Iterator[Part]:
    """Yield the cyclic values of a record."""
    for datum, raw in data:
        value = datum.shown(raw)
        yield Part(f"{drive}/{idn_text(datum.idn)}", datum.name, value, f"{value} {datum.unit}".rstrip())


def ring_parts(answers: Answers) -> Iterator[Part]:
    """Yield what the ring says beside the telegrams of its drives."""
    yield Part("ring", "", answers.ring_closed, "closed" if answers.ring_closed else "open")
    yield Part("wrong FCS", "", answers.errors, f"{counted(answers.errors, 'telegram')}")
    yield Part("late", "", answers.late, f"{answers.late} stations")


def unknown_parts(kind: str, telegrams: Iterable[bytes]) -> Iterator[Part]:
    """Yield telegrams of which it is not known what they carry, in hex."""
    for data in telegrams:
        text = data.hex(" ").upper() or "none"
        yield Part(f"{kind} of {data[0]}" if data else kind, "", text, text)
