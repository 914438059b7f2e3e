"""The content of the frames of the USER port: requests, answers, and unsolicited messages.

docs/devices/arp/arp-user-port.md describes all of it in tables.  A body is version, address, sequence number, command,
then data; every number is little endian.  An answer's command is the request's with bit 7 set, and its data begin with
a status.
"""

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import ClassVar, Final, NamedTuple, Self

from fieldrig_devices.arp.user_port.framing import LONGEST_BODY

VERSION: Final = 1
ANY_CARD: Final = 0xFF
"""Address in a HELLO that every card accepts."""
ANSWER: Final = 0x80
HIGHEST_REQUEST: Final = 0x5F
"""Highest command of a request; answers to higher ones would look like unsolicited messages."""
UNNUMBERED: Final = 0
"""Sequence number of requests that are carried out each time they arrive."""
LARGEST_DATA: Final = LONGEST_BODY - 4
LONGEST_TEXT: Final = 200


class Command(IntEnum):
    HELLO = 0x01
    STATE = 0x02
    RUN = 0x03
    STOP = 0x04
    RESET = 0x05
    READ = 0x10
    READ_MANY = 0x11
    WRITE_VARIABLES = 0x12
    WRITE_BITS = 0x13
    READ_PARAMETERS = 0x20
    WRITE_PARAMETER = 0x21
    DOWNLOAD_BEGIN = 0x30
    DOWNLOAD_BLOCK = 0x31
    DOWNLOAD_COMMIT = 0x32
    DOWNLOAD_ABORT = 0x33
    UPLOAD_BEGIN = 0x34
    UPLOAD_BLOCK = 0x35
    BREAKPOINTS_SET = 0x40
    BREAKPOINTS_GET = 0x41
    PAUSE = 0x42
    STEP = 0x43
    PLACE = 0x44
    EVENTS = 0x50
    TRACE_START = 0x51
    TRACE_STOP = 0x52


EVENT: Final = 0xE0
"""Unsolicited: the state of the card or of the program has changed."""
SAMPLES: Final = 0xE1
"""Unsolicited: samples of a trace."""
PROGRESS: Final = 0xE2
"""Unsolicited: how far the card is with the program of a COMMIT that it has not answered yet."""


class Status(IntEnum):
    """First byte of an answer; after every status but OK follows a text for the user, in UTF-8, which may be empty."""

    OK = 0
    VERSION = 1  # this card uses another version; it is in the answer's version byte
    COMMAND = 2  # no such command
    LENGTH = 3  # too few or too many data for the command
    RANGE = 4  # the variable, parameter or line does not exist or cannot have the value
    REFUSED = 5  # not possible now, or not from outside
    ORDER = 6  # a block without a beginning, or not the next one
    DAMAGED = 7  # length or CRC of the whole object is wrong
    OBJECT = 8  # the downloaded data are not a program for this card
    NO_PROGRAM = 9


class RequestError(Exception):
    """A request that is answered by a status other than OK."""

    def __init__(self, status: Status, text: str = "") -> None:
        super().__init__(text or status.name)
        self.status, self.text = status, text


@dataclass(frozen=True, slots=True)
class Message:
    """The body of a frame."""

    HEAD: ClassVar = struct.Struct("<BBBB")

    address: int
    sequence: int
    command: int
    data: bytes = b""
    version: int = VERSION

    def encode(self) -> bytes:
        return self.HEAD.pack(self.version, self.address, self.sequence, self.command) + self.data

    @classmethod
    def decode(cls, body: bytes) -> Self:
        version, address, sequence, command = cls.HEAD.unpack_from(body)
        return cls(address, sequence, command, body[cls.HEAD.size :], version)


class Identity(NamedTuple):
    """The answer to HELLO."""

    number: int
    """Address nn of the card."""
    largest_data: int
    """Octets of data that a frame may carry in either direction."""
    name: str
    """Name of the program; empty without one."""

    def encode(self) -> bytes:
        return _IDENTITY.pack(self.number, self.largest_data) + self.name.encode()

    @classmethod
    def decode(cls, data: bytes) -> Self:
        head, name = data[: _IDENTITY.size], data[_IDENTITY.size :]
        number, largest_data = _IDENTITY.unpack(head)
        return cls(number, largest_data, name.decode(errors="replace"))


_IDENTITY: Final = struct.Struct("<BH")


class ProgramCode(IntEnum):
    """Activity of the program."""

    NONE = 0
    HELD = 1  # at its first instruction
    RUNNING = 2
    PAUSED = 3
    ENDED = 4
    FAILED = 5


class Condition(NamedTuple):
    """The answer to STATE, and the content of an EVENT."""

    state: int
    """State of the card, a `CardState`."""
    program: int
    """Activity of the program, a `ProgramCode`."""
    error: int
    error_axis: int
    warning: int
    line: int
    """Source line of the next instruction; 0 without a program."""
    breakpoints: int

    def encode(self) -> bytes:
        return _CONDITION.pack(*self)

    @classmethod
    def decode(cls, data: bytes) -> Self:
        return cls(*_CONDITION.unpack(data))


_CONDITION: Final = struct.Struct("<BBHBHIB")


class Quantity(NamedTuple):
    """One value of the card; `kind` is a letter of `quantities`."""

    kind: int
    number: int


QUANTITY: Final = struct.Struct("<BH")
VALUE: Final = struct.Struct("<i")
LINE: Final = struct.Struct("<I")
BLOCK: Final = struct.Struct("<I")
"""Head of a block of a download or upload: its offset."""
WHOLE: Final = struct.Struct("<II")
"""Length and CRC-32 (that of zlib and IEEE 802.3) of an object file."""
TRACE: Final = struct.Struct("<H")
"""Head of TRACE_START: the number of control loops between samples; quantities follow."""
STEPS: Final = struct.Struct("<II")
"""Head of PROGRESS: how many steps of how many are done; what is being done follows as a text."""
LOST: Final = struct.Struct("<I")
"""Head of SAMPLES: the number of samples lost since the trace began, up to the last one here; samples follow.

Each sample is the number of its control loop and a value for each quantity.
"""
MOST_VARIABLES: Final = 60
"""Maximum in one frame, like the constants below."""
MOST_BITS: Final = 320
MOST_QUANTITIES: Final = 60
MOST_BREAKPOINTS: Final = 60
MOST_TRACED: Final = 16
LARGEST_BLOCK: Final = 240


def packed_values(values: Iterable[int]) -> bytes:
    return b"".join(map(VALUE.pack, values))


def values_in(data: bytes) -> list[int]:
    """Decode values.  Raises struct.error if the length is not a multiple of 4."""
    return [raw for (raw,) in VALUE.iter_unpack(data)]


def packed_bits(bits: Sequence[int]) -> bytes:
    """Pack bits; the first is bit 0 of the first octet."""
    octets = (bits[first : first + 8] for first in range(0, len(bits), 8))
    return bytes(sum(bit << index for index, bit in enumerate(octet)) for octet in octets)


def bits_in(data: bytes, count: int) -> list[int]:
    return [data[index >> 3] >> (index & 7) & 1 for index in range(count)]
