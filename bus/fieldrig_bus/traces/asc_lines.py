"""The lines of an ASC log of Vector's tools.

Source: the files of CANoe and CANalyzer that are public, and the readers of python-can and can-utils.  A line has the
seconds from the beginning of its trigger block (or from the line before it, if the header says `timestamps relative`):

       2.501000 1  123x            Rx   d 8 01 02 03 04 05 06 07 08  Length = 240015 BitCount = 124 ID = 291x
      30.005071 CANFD   3 Rx  30a  Name  1 1 8  8 01 02 03 04 05 06 07 08   102203  133   303000 ...
       2.501020 2 ErrorFrame Flags = 0xe CodeExt = 0x20a2 Code = 0x82 ID = 0 DLC = 0 Position = 5 Length = 11300
       0.015991 CAN 1 Status:chip status error passive - TxErr: 132 RxErr: 0

Left out: events and statistics of the tools, requests to send (TxRq), which come again as frames, and other buses.
"""

import re
from collections.abc import Callable
from datetime import datetime
from typing import Final, NamedTuple

from fieldrig.clock import S
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import EXTENDED_MASK, FD_LENGTHS
from fieldrig_bus.can.notices import BusState, CanError, CanState, ErrorKind
from fieldrig_bus.traces.can_fields import message_of
from fieldrig_bus.traces.error_capture import error_of, unknown_error

PLAIN: Final = re.compile(
    r" *(\d{1,12})\.(\d{1,9}) +(\d{1,3}) +([0-9A-Fa-f]{1,8})(x?) +[RT]x +d ([0-8])([0-9A-Fa-f ]*)(?:\r|Length\b.*)?",
    re.ASCII,
).fullmatch
"""A classical data frame with hexadecimal numbers, as nearly all lines are, if its digits are in pairs."""

_TIME: Final = r"\s*(?P<seconds>\d{1,12})\.(?P<fraction>\d{1,9})\s+"
_OFFSET: Final = re.compile(_TIME, re.ASCII)
_FRAME: Final = re.compile(
    _TIME + r"(?P<channel>\d{1,3})\s+(?P<id>[0-9A-Fa-f]{1,10}x?)\s+(?P<way>Rx|Tx|TxRq)\s+(?P<kind>[dDrR])\b\s*"
    r"(?P<rest>.*)",
    re.ASCII,
)
_FD: Final = re.compile(
    _TIME + r"CANFD\s+(?P<channel>\d{1,3})\s+(?P<way>Rx|Tx|TxRq)\s+(?P<id>[0-9A-Fa-f]{1,10}x?)\s+(?:(?P<name>\S+)\s+)??"
    r"(?P<brs>[01])\s+(?P<esi>[01])\s+(?P<dlc>[0-9A-Fa-f]{1,2})\s+(?P<length>\d{1,2})\b\s*(?P<rest>.*)",
    re.ASCII | re.IGNORECASE,
)
_ERROR: Final = re.compile(
    _TIME + r"(?:CANFD\s+)?(?P<channel>\d{1,3})\s+(?:(?:Rx|Tx)\s+)?ErrorFrame\b(?P<rest>.*)", re.ASCII | re.IGNORECASE
)
_STATUS: Final = re.compile(
    _TIME + r"CAN\s+(?P<channel>\d{1,3})\s+Status:\s*chip status (?P<state>error active|warning level|error passive|"
    r"bus ?off)(?:\s*-\s*TxErr:\s*(?P<tec>\d{1,3})\s+RxErr:\s*(?P<rec>\d{1,3}))?.*",
    re.ASCII | re.IGNORECASE,
)
_ECC: Final = re.compile(r"\bECC:\s*([01]{8})\b")
_CODE: Final = re.compile(r"\bCode\s*=\s*0x([0-9A-Fa-f]{1,2})\b")
_SAYS_NOTHING: Final = re.compile(
    r"\s*(?://.*|End Trigger ?block.*|Begin Trigger ?block|(?:no )?internal events logged.*|"
    r"[\d.]+\s+(?:Start of measurement|"
    r"\d+\s+Statistic:|log trigger event|CAN\s+\d+\s+(?:Status|OverloadFrame)|\d+\s+OverloadFrame|"
    r"previous log file|Trigger event).*)?",
    re.ASCII | re.IGNORECASE,
)
_DATE: Final = re.compile(r"\s*(?:date|begin trigger ?block)\s+\S+\s+(?P<date>\S.*)", re.IGNORECASE)
_BASE: Final = re.compile(
    r"\s*base\s+(?P<base>hex|dec)(?:\s+timestamps\s+(?P<times>absolute|relative))?", re.IGNORECASE
)
_DAY: Final = re.compile(
    r"(?P<month>[^\W\d]{1,20}|\d{1,2}月)\.? +(?P<day>\d{1,2})(?: +(?P<first>\d{4}))? +"
    r"(?P<hour>\d{1,2}):(?P<minute>\d{2}):(?P<second>\d{2})"
    r"(?:\.(?P<fraction>\d{1,6}))?(?: *(?P<half>[ap]m))?(?: +(?P<year>\d{4}))?",
    re.IGNORECASE,
)
_MONTHS: Final = (
    ("jan", "jän", "ene", "gen", "一月"),
    ("feb", "fév", "fev", "二月"),
    ("mar", "mär", "mrz", "三月"),
    ("apr", "abr", "avr", "四月"),
    ("may", "mai", "maj", "mag", "五月"),
    ("jun", "juin", "giu", "六月"),
    ("jul", "juil", "lug", "七月"),
    ("aug", "ago", "aoû", "八月"),
    ("sep", "set", "九月"),
    ("oct", "okt", "ott", "out", "十月"),
    ("nov", "十一月"),
    ("dec", "dez", "déc", "dic", "十二月"),
)
"""The beginnings of the names of the months, as Windows has them in the languages of Europe, and in Chinese."""
_KINDS: Final = {"acknowledge": ErrorKind.ACK, "stuff": ErrorKind.STUFF, "form": ErrorKind.FORM, "crc": ErrorKind.CRC}
STATES: Final = {
    CanState.ACTIVE: "error active",
    CanState.WARNING: "warning level",
    CanState.PASSIVE: "error passive",
    CanState.BUS_OFF: "bus off",
}
_EDL: Final = 0x1000
"""The bit of the flags that tells an FD frame from a classical one on a channel of CAN FD."""


class Line(NamedTuple):
    """A message of a log, or nothing; `what` says what is left out."""

    offset_ns: int = 0
    channel: int = 0
    message: bytes | None = None
    what: str = ""


NOTHING: Final = Line()


def date_of(line: str) -> str | None:
    """Return the date of a line that begins the log or a trigger block; None for any other line."""
    match = _DATE.match(line)
    return match["date"].strip() if match else None


def base_of(line: str) -> tuple[bool, bool] | None:
    """Return whether numbers are hexadecimal, and whether times are relative, if a line says so."""
    match = _BASE.match(line)
    return (match["base"].lower() == "hex", (match["times"] or "").lower() == "relative") if match else None


def unix_ns(date: str) -> int:
    """Return the instant of a date such as `Sep 30 03:06:13.191 pm 2017`, in local time.  ValueError for any other."""
    match = _DAY.fullmatch(date)
    month = _month_of(match["month"]) if match else 0
    if match is None or not month or not (match["year"] or match["first"]):
        raise ValueError(f"{date!r} is not a date such as Sep 30 15:06:13.191 2017")
    hour = int(match["hour"])
    if match["half"]:
        hour = hour % 12 + (12 if match["half"].lower() == "pm" else 0)
    year, day, minute, second = (int(match[name] or match["first"]) for name in ("year", "day", "minute", "second"))
    local = datetime(year, month, day, hour, minute, second).astimezone()
    return int(local.timestamp()) * S + int((match["fraction"] or "0").ljust(9, "0"))


def _month_of(name: str) -> int:
    """Return the number of a month; 0 for a name that is none."""
    if name[0].isdigit():
        return int(name.removesuffix("月"))
    known = (number for number, stems in enumerate(_MONTHS, 1) if name.lower().startswith(stems))
    return next(known, 0)


def offset_ns_of(line: str) -> int:
    """Return the time of any line, which the next one counts from if times are relative; 0 for a line without one."""
    match = _OFFSET.match(line)
    return int(match["seconds"]) * S + int(match["fraction"].ljust(9, "0")) if match else 0


def parse(line: str, is_hex: bool) -> Line:
    """Return what a line says.  ValueError, in words, for a frame that cannot be one."""
    if _SAYS_NOTHING.fullmatch(line) and not _STATUS.fullmatch(line):
        return NOTHING
    for form, message in _FORMS:
        if match := form.fullmatch(line):
            if (match.groupdict().get("way") or "").lower() == "txrq":
                return Line(what="requests to send (TxRq) are left out, as the frames follow them")
            offset_ns = int(match["seconds"]) * S + int(match["fraction"].ljust(9, "0"))
            return Line(offset_ns, int(match["channel"]), message(match, 16 if is_hex else 10))
    return Line(what="lines that are no CAN frames are left out")


def _classical(line: re.Match[str], base: int) -> bytes | None:
    word, rest = _word(line["id"], base), line["rest"].split()
    length = int(rest[0], base) if rest and rest[0].isalnum() and rest[0] != "Length" else 0
    if line["kind"] in "rR":
        return message_of(word | REMOTE, b"", length)
    return message_of(word, _data(rest[1:], min(length, 8), base))


def _fd(line: re.Match[str], base: int) -> bytes | None:
    word, length, rest = _word(line["id"], base), int(line["length"]), line["rest"].split()
    flags = int(rest[length + 2], 16) if len(rest) > length + 2 else _EDL
    if length == 0 and not flags & _EDL:
        return message_of(word | REMOTE, b"", FD_LENGTHS[int(line["dlc"], 16) & 15])
    data = _data(rest, length, base)
    is_fd = bool(flags & _EDL) or length > 8
    return message_of(word, data, is_fd=is_fd, is_switched=is_fd and line["brs"] == "1")


def _error(line: re.Match[str], base: int) -> bytes:
    rest = line["rest"]
    if match := _ECC.search(rest):
        return encode(error_of(int(match[1], 2)))
    if match := _CODE.search(rest):
        return encode(error_of(int(match[1], 16)))
    kind = next((kind for word, kind in _KINDS.items() if word in rest.lower()), None)
    if kind is None:
        return encode(unknown_error())
    return encode(CanError(kind, Place.UNSPECIFIED, 0, 0, False, False, 0, 0))


def _status(line: re.Match[str], base: int) -> bytes:
    word = line["state"].lower().replace("busoff", "bus off")
    state = next(state for state, words in STATES.items() if words == word)
    least = 256 if state is CanState.BUS_OFF else 0  # the counter of the log has a byte
    return encode(BusState(state, max(int(line["tec"] or 0), least), int(line["rec"] or 0)))


_FORMS: Final[tuple[tuple[re.Pattern[str], Callable[[re.Match[str], int], bytes | None]], ...]] = (
    (_FRAME, _classical),
    (_FD, _fd),
    (_ERROR, _error),
    (_STATUS, _status),
)


def _word(text: str, base: int) -> int:
    is_extended = text.endswith("x")
    identifier = int(text.removesuffix("x"), base)
    if identifier > EXTENDED_MASK:
        raise ValueError(f"identifier {identifier:#x}: expected at most {EXTENDED_MASK:#x}")
    return identifier | is_extended * EXTENDED


def _data(words: list[str], length: int, base: int) -> bytes:
    data = words[:length]
    if len(data) < length:
        raise ValueError(f"{len(data)} bytes of data, and {length} are announced")
    return bytes(int(word, base) for word in data)
