"""What the data records of the cyclic telegrams hold.

Source: IEC 61491 by its public facts: S-0-0015 picks one of the standard telegrams, or (7) the lists S-0-0024 (command
values in the MDT) and S-0-0016 (feedback in the AT).  Each record begins with its word and two bytes of the service
channel.
"""

import struct
from collections.abc import Iterable, Mapping
from typing import Final, NamedTuple

from fieldrig_devices.sercos.datum import IdnTable
from fieldrig_devices.sercos.idn import Format

CONFIGURED: Final = 7
HEAD_BYTES: Final = 4
"""Control or status word, and the service channel."""
AT_HEAD: Final = struct.Struct("<BHH")
"""Address, status word, service channel; then come the feedback values."""


class Telegrams(NamedTuple):
    mdt: tuple[int, ...]
    at: tuple[int, ...]


STANDARD: Final[Mapping[int, Telegrams]] = {
    0: Telegrams((), ()),
    1: Telegrams((80,), ()),
    2: Telegrams((36,), (40,)),
    3: Telegrams((36,), (51,)),
    4: Telegrams((47,), (51,)),
    5: Telegrams((47, 36), (51, 40)),
    6: Telegrams((36,), ()),
}
"""By the number in S-0-0015."""

CODES: Final[Mapping[int, str]] = {
    36: "i", 37: "i", 40: "i", 47: "i", 48: "i", 51: "i", 53: "i", 80: "h", 81: "h", 84: "h",
    130: "i", 131: "i", 132: "i", 133: "i", 134: "H", 135: "H", 179: "H", 182: "H", 189: "i", 347: "i",
    11: "H", 12: "H", 13: "H", 380: "h", 383: "h", 384: "h", 390: "I",
}  # fmt: skip
"""How a master that knows the standard reads cyclic data, by IDN."""

_BY_BYTES: Final = {2: "h", 4: "i", 8: "q"}


def code_of(table: IdnTable, idn: int) -> str:
    """Of one value in a record; "" if the drive has none that could be cyclic."""
    if idn not in table:
        return ""
    attribute = table[idn].attribute
    if attribute.length.is_list or attribute.is_command:
        return ""
    code = _BY_BYTES[attribute.length.bytes]
    return code if attribute.format is Format.SIGNED else code.upper()


def record(codes: Iterable[str]) -> struct.Struct:
    """Word, service channel, then values of these codes."""
    return struct.Struct("<HH" + "".join(codes))


def size(codes: Iterable[str]) -> int:
    """Bytes of the values alone."""
    return struct.calcsize("<" + "".join(codes))
