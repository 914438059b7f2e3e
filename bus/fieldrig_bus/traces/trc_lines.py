"""The lines of a TRC log of PEAK's tools.

Source: PEAK CAN TRC File Format, versions 1.0 to 2.1.  A line has its number, the milliseconds from the start of the
log, and by the version of the file:

    1.0    1)     1841     0001  8  00 00 00 00 00 00 00 00
    1.1    1)     1841.4  Rx     0001  8  00 00 00 00 00 00 00 00
    1.2    1)     1841.400 1  Rx     0001  8  00 00 00 00 00 00 00 00
    1.3    1)     1841.400 1  Rx     0001 -  8    00 00 00 00 00 00 00 00
    2.x    the columns that the line `;$COLUMNS` lists, such as N,O,T,B,I,d,R,L,D

Left out: events, changes of the error counters (EC), and the parts of messages of J1939.
"""

import re
from collections.abc import Callable, Mapping
from decimal import Decimal, DecimalException
from typing import Final, NamedTuple

from fieldrig.clock import MS, US
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import FD_LENGTHS
from fieldrig_bus.can.notices import BusState, CanError, CanState, ErrorKind
from fieldrig_bus.can.socketcan_errors import place_of
from fieldrig_bus.traces.can_fields import message_of
from fieldrig_bus.traces.plain_heads import HeadsOfTexts

VERSIONS: Final = ("1.0", "1.1", "1.2", "1.3", "2.0", "2.1")
COLUMNS: Final = {"1.0": "NOILD", "1.1": "NOTILD", "1.2": "NOBTILD", "1.3": "NOBTIRLD"}
"""The columns of the versions that do not list them, by the letters of version 2.0."""
MOST_COLUMNS: Final = 20
DAY_NS: Final = 86_400_000_000_000
EPOCH_DAY: Final = 25_569
"""1 January 1970, counted from 30 December 1899."""
_MS: Final = re.compile(r"(-?)(\d{1,15})(?:[.,](\d{1,6}))?", re.ASCII)
_WAY: Final = re.compile(r"Rx|Tx|Warng|Error", re.IGNORECASE)
_NUMBER: Final = re.compile(r"\d+\)?", re.ASCII)
"""Traces of other tools end in .trc too, and their words must not pass for columns."""
_IDENTIFIER: Final = re.compile(r"[0-9A-Fa-f]{1,8}")
_BYTE: Final = re.compile(r"[0-9A-Fa-f]{2}")
_STATES: Final = {0x00: CanState.ACTIVE, 0x04: CanState.WARNING, 0x08: CanState.PASSIVE, 0x10: CanState.BUS_OFF}
"""OK, BUSLIGHT, BUSHEAVY and BUSOFF."""
_KINDS: Final = {1: ErrorKind.BIT, 2: ErrorKind.FORM, 4: ErrorKind.STUFF}
_FD_TYPES: Final = frozenset({"FD", "FB", "FE", "BI"})
_SWITCHED_TYPES: Final = frozenset({"FB", "FE"})
_FRAME_TYPES: Final = frozenset({"DT", "RX", "TX", "RR"}) | _FD_TYPES


PLAIN_COLUMNS: Final = "N,O,T,B,I,d,R,L,D"


class Line(NamedTuple):
    """A message of a log; None is an event that is left out."""

    offset_ns: int
    channel: int
    message: bytes | None


def columns_of(version: str, listed: str = "") -> dict[str, int]:
    """Return the place of each column.  ValueError if the file does not have what a frame needs."""
    names = listed.split(",")[:MOST_COLUMNS] if version >= "2" else list(COLUMNS[version])
    places = {name.strip(): place for place, name in enumerate(names)}
    if not {"O", "I", "D"} <= places.keys() or not {"l", "L"} & places.keys() or (version >= "2" and "T" not in places):
        raise ValueError(f"the columns {listed!r:.60}: expected at least O, T, I, l or L, and D")
    return places


def version_of(line: str) -> str:
    """Return the version of a log without a head by its first line, such as one that was cut out of a longer log."""
    words = line.split()
    if len(words) > 2 and _WAY.fullmatch(words[2]):
        return "1.1"
    if len(words) > 3 and _WAY.fullmatch(words[3]):
        return "1.3" if len(words) > 5 and words[5] == "-" else "1.2"
    return "1.0"


def start_ns(days: str) -> int:
    """Return the start of a log, which is in days since 30 December 1899, to the microsecond.  ValueError if none."""
    try:
        since = Decimal(days.strip().replace(",", ".")) - EPOCH_DAY  # some have been written in German, say
        return round(since * (DAY_NS // US)) * US if abs(since) < 3 * 10**6 else _refuse(days)
    except DecimalException:  # no number, or one beyond the range of decimals
        return _refuse(days)


def _refuse(days: str) -> int:
    raise ValueError(f"{days.strip()!r:.40} is not a number of days")


def plain(line: str, heads: HeadsOfTexts) -> tuple[int, int, bytes] | None:
    """Return what a line of version 2.1 says that is a classical data frame; None for any other line."""
    try:
        _, clock, kind, channel, digits, _, _, length, text = line.split(None, 8)
        if kind != "DT" or clock[-4] != ".":
            return None
        data = bytes.fromhex(text)
        if len(data) != int(length):
            return None
        return int(clock[:-4] + clock[-3:]) * US, int(channel), heads[digits][len(data)] + data
    except (ValueError, IndexError):
        return None


def parse(line: str, columns: Mapping[str, int]) -> Line:
    """Return what a line says.  ValueError, in words, for one that is no line of such a log."""
    if not columns:
        raise ValueError("no line before it says the columns, such as ;$COLUMNS=N,O,T,I,d,l,D")
    words = line.split(maxsplit=len(columns) - 1)
    if len(words) < 4:
        raise ValueError("it has less than four columns")
    if "N" in columns and not _NUMBER.fullmatch(words[columns["N"]]):
        raise ValueError(f"{words[columns['N']]!r:.20} is not the number of a message")
    offset_ns = _offset_ns(words[columns["O"]])
    kind = words[columns["T"]].upper() if "T" in columns else _kind_of_oldest(words, columns)
    channel = int(words[columns["B"]]) if "B" in columns and words[columns["B"]].isdigit() else 1
    make = _frame if kind in _FRAME_TYPES else _OTHERS.get(kind)
    return Line(offset_ns, channel, None if make is None else make(kind, words, columns))


def _kind_of_oldest(words: list[str], columns: Mapping[str, int]) -> str:
    if words[columns["I"]].upper() == "FFFFFFFF":
        return "WARNG"
    return "ERROR" if words[columns["D"] :] and words[columns["D"]].upper().startswith("ERROR") else "DT"


def _offset_ns(text: str) -> int:
    match = _MS.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r:.20} is not a time in milliseconds")
    offset_ns = int(match[2]) * MS + int((match[3] or "").ljust(6, "0"))
    return -offset_ns if match[1] else offset_ns


def _frame(kind: str, words: list[str], columns: Mapping[str, int]) -> bytes | None:
    digits = words[columns["I"]]
    if not _IDENTIFIER.fullmatch(digits):
        raise ValueError(f"{digits!r:.20} is not an identifier in hexadecimal digits")
    word = int(digits, 16) | (EXTENDED if len(digits) > 4 else 0)
    by_code = "l" not in columns
    number = int(words[columns["L" if by_code else "l"]])
    rest = words[columns["D"]] if len(words) > columns["D"] else ""
    if kind == "RR" or rest[:3].upper() == "RTR":
        return message_of(word | REMOTE, b"", number)
    is_fd = kind in _FD_TYPES
    length = FD_LENGTHS[number & 15] if by_code and is_fd else min(number, 64 if is_fd else 8)
    data = bytes.fromhex(rest[: 3 * length].strip())
    if len(data) < length:
        raise ValueError(f"{len(data)} bytes of data, and {length} are announced")
    return message_of(word, data, is_fd=is_fd, is_switched=kind in _SWITCHED_TYPES)


def _status(kind: str, words: list[str], columns: Mapping[str, int]) -> bytes | None:
    digits = [word for word in " ".join(words).split() if _BYTE.fullmatch(word)][-4:]  # version 2.0 has empty columns
    state = _STATES.get(int(digits[-1], 16)) if len(digits) == 4 else None
    return None if state is None else encode(BusState(state, 256 if state is CanState.BUS_OFF else 0, 0))


def _error(kind: str, words: list[str], columns: Mapping[str, int]) -> bytes:
    """An error frame: its type, then direction (0: sending), place, REC and TEC.

    Up to version 1.3 the type is instead of an identifier; from 2.0 on it is the first byte, and columns are empty.
    """
    if kind == "ER":
        digits = [word for word in " ".join(words).split() if _BYTE.fullmatch(word)][-5:]
        number, *rest = bytes.fromhex("".join(digits)).ljust(5, b"\0") if len(digits) == 5 else bytes(5)
        data = bytes(rest)
    else:
        text = "".join(words[columns["D"] :]).upper().removeprefix("ERROR").replace(" ", "")
        data = bytes.fromhex(text[: len(text) // 2 * 2]).ljust(4, b"\0")
        number = int(words[columns["I"]], 16)
    place = place_of(data[1])
    error = _KINDS.get(number)
    if error is None:
        error = ErrorKind.ACK if data[1] == place_of(0x19) else ErrorKind.CRC
    return encode(CanError(error, place, 0, 0, data[0] == 0, False, data[3], data[2]))


_OTHERS: Final[Mapping[str, Callable[[str, list[str], Mapping[str, int]], bytes | None]]] = {
    "WARNG": _status,
    "ST": _status,
    "ERROR": _error,
    "ER": _error,
}
