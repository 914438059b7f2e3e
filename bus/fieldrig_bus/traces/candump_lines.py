"""The lines of candump, as a person or a program has saved them.

Source: can-utils, the manual pages of candump and log2asc, and lib.h (CANFRAME ASCII layout).  Two forms:

    (1436509052.249713) can0 123#1122 R        candump -l and -L; the direction may follow
      (000.012345)  can0  TX - -  123   [2]  11 22   '.."'     plain candump, with the options -t, -x, -a and -S

A line of plain candump without a time has that of the line before it, and 0 at the beginning.  Empty lines, comments
that begin with #, and the explanations below an error frame (option -e), which begin with a tab, say nothing.  Neither
does what a terminal has around them, as many are copied from one: the command, ^C, and the next prompt.
Left out: CAN XL and the binary output (option -i).
"""

import re
from datetime import datetime
from itertools import pairwise
from typing import Final, NamedTuple

from fieldrig.points.values import counted
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import EXTENDED_MASK, CanFrame
from fieldrig_bus.can.linux_flags import BIT_RATE_SWITCH, ERROR
from fieldrig_bus.can.socketcan_errors import notice_of

TIME: Final = r"\((?P<time>[^()]*)\)"
LOG: Final = re.compile(rf"{TIME} +(?P<bus>\S+) +(?P<identifier>[^#\s]*)#(?P<body>\S*)(?: +[RT])?")
INFO: Final = r"(?:[RT]X +(?P<switched>[B-]) +[E-] +)?"
VIEW: Final = re.compile(
    rf"(?:{TIME} +)?(?P<bus>[^\s()#]+) +{INFO}(?P<identifier>[0-9A-Fa-f]+) +\[(?P<length>\d+)\](?:  *(?P<body>.*))?"
)
SECONDS: Final = re.compile(r"(\d{1,12})\.(\d{1,9})")
LIKE_A_DATE: Final = re.compile(r"[0-9][-0-9:. T/]*")
REMOTE: Final = re.compile(r"R(\d?)(?:_[0-9A-Fa-f])?")
XL: Final = re.compile(r"[0-9A-Fa-f]{2}:[0-9A-Fa-f]{2}:[0-9A-Fa-f]{8}#")
LOG_DATA: Final = re.compile(r"([0-9A-Fa-f.]*)(?:_[0-9A-Fa-f])?")
"""Data, and the raw DLC of a frame of 8 bytes."""
TERMINAL: Final = re.compile(
    r"(?:\^C)?(?:[\w.-]+@[\w.-]+[^$#%>]*[$#%>]|[$#%>])? ?(?:(?:sudo )?candump(?: .*)?)?", re.ASCII
)
LONGEST_TERMINAL: Final = 200
LONGEST_S: Final = 86_400
"""Seconds between two lines, at most, of a log with such times."""
_SINCE: Final = re.compile(r"^ *\((\d{3,5}\.\d{6})\) +[^\s()#]+ +[^#\n]*\[\d+\]", re.MULTILINE)
STANDARD_DIGITS, EXTENDED_DIGITS = 3, 8
NO_LINE: Final = "expected (TIME) BUS IDENTIFIER#DATA, or a line of plain candump"


class Line(NamedTuple):
    time_ns: int | None
    """The time of day; None for a line without a time."""
    bus: str
    message: bytes | None
    """The encoded message of the bus; None for an error frame that reports nothing."""
    is_time_wrong: bool = False
    """True for a date that no calendar has; then `time_ns` is None."""


def says_nothing(line: str) -> bool:
    """Return whether it is an empty line, a comment, the explanation of an error frame, or from around the log."""
    text = line.strip()
    if not text or line.startswith(("#", "\t")):
        return True
    return len(text) <= LONGEST_TERMINAL and TERMINAL.fullmatch(text) is not None


def parse(line: str) -> Line:
    """Return what a line says.  ValueError, in words for a user, for any other line."""
    text = line.strip()
    for form, message in ((LOG, _logged), (VIEW, _viewed)):
        if match := form.fullmatch(text):
            time_ns, is_wrong = (None, False) if match["time"] is None else _time_ns(match["time"])
            return Line(time_ns, match["bus"], message(match), is_wrong)
    raise ValueError(NO_LINE)


def is_like_one(line: str) -> bool:
    """Return whether a line has the form of one of candump."""
    text = line.strip()
    return LOG.fullmatch(text) is not None or VIEW.fullmatch(text) is not None


def has_differences(head: bytes) -> bool:
    """Return whether the times of these lines are those since the line before, as `candump -t d` writes them.

    They are small, and each fourth of them is smaller than the one before, at least.
    """
    found = [float(match[1]) for match in _SINCE.finditer(head.decode("latin-1"))]
    backwards = sum(later < earlier for earlier, later in pairwise(found))
    return len(found) > 3 and max(found) < LONGEST_S and 4 * backwards >= len(found)


def _time_ns(text: str) -> tuple[int | None, bool]:
    """Return the time of `1436509052.249713`, or of a date such as `2024-05-17 09:12:01.250000` in local time.

    The second is true for what looks like a date, and is none.
    """
    if match := SECONDS.fullmatch(text.strip()):
        return int(match[1]) * 1_000_000_000 + int(match[2].ljust(9, "0")), False
    try:
        return round(datetime.fromisoformat(text.strip()).timestamp() * 1e6) * 1000, False
    except (ValueError, OverflowError, OSError):
        if LIKE_A_DATE.fullmatch(text.strip()):
            return None, True
        raise ValueError(f"{text!r} is not a time: expected seconds such as 1436509052.249713") from None


def _logged(line: re.Match[str]) -> bytes | None:
    identifier, body = line["identifier"], line["body"]
    if body.startswith("#"):
        if len(body) < 2 or body[1] not in "0123456789ABCDEFabcdef":
            raise ValueError("an FD frame has a digit with its flags after ##")
        is_switched = bool(int(body[1], 16) & BIT_RATE_SWITCH)
        return _encoded(identifier, _bytes(body[2:].replace(".", "")), is_fd=True, is_switched=is_switched)
    if match := REMOTE.fullmatch(body):
        return _encoded(identifier, b"", remote_length=int(match[1] or 0))
    if XL.match(body):
        raise ValueError("a frame of CAN XL, which is not read")
    match = LOG_DATA.fullmatch(body)
    if match is None:
        raise ValueError(f"{body!r} is not data: expected two hexadecimal digits for each byte")
    return _encoded(identifier, _bytes(match[1].replace(".", "")))


def _viewed(line: re.Match[str]) -> bytes | None:
    identifier, length, is_switched = line["identifier"], line["length"], line["switched"] == "B"
    is_fd, count = len(length) == 2, int(length)  # an FD frame has two digits there
    hexadecimal = (line["body"] or "").partition("'")[0]  # option -a adds the data as characters
    words = hexadecimal.partition("ERRORFRAME")[0].strip()
    if words == "remote request":
        return _encoded(identifier, b"", remote_length=count)
    data = _bytes("".join(reversed(words.split("`"))) if "`" in words else words.replace(" ", ""))
    if len(data) != count:
        raise ValueError(
            f"the data has {counted(len(data), 'byte')}, and [{length}] says {count}: the line may be cut off"
        )
    return _encoded(identifier, data, is_fd=is_fd, is_switched=is_switched)


def _bytes(digits: str) -> bytes:
    if len(digits) % 2:
        raise ValueError(f"the data {digits} ends with half a byte: expected two digits for each byte")
    try:
        return bytes.fromhex(digits)
    except ValueError:
        raise ValueError(f"{digits!r} is not data: expected two hexadecimal digits for each byte") from None


def _encoded(
    digits: str, data: bytes, *, remote_length: int | None = None, is_fd: bool = False, is_switched: bool = False
) -> bytes | None:
    if len(digits) not in (STANDARD_DIGITS, EXTENDED_DIGITS):
        raise ValueError(f"{digits!r} is not an identifier: expected 3 digits, or 8 for an extended one")
    try:
        word = int(digits, 16)
    except ValueError:
        raise ValueError(f"{digits!r} is not an identifier: expected hexadecimal digits") from None
    if len(digits) == EXTENDED_DIGITS and word & ERROR:  # CAN_ERR_FLAG alone decides, whatever the class is
        notice = notice_of(word & EXTENDED_MASK, data)
        return None if notice is None else encode(notice)
    return encode(
        CanFrame(
            word,
            data,
            is_extended=len(digits) == EXTENDED_DIGITS,
            is_remote=remote_length is not None,
            remote_length=remote_length or 0,
            is_fd=is_fd,
            is_bit_rate_switched=is_switched,
        )
    )
