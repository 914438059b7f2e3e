"""The contents of the data records in cyclic telegrams.

Source: IEC 61491 by its public facts: S-0-0015 selects a standard telegram, or (7) the lists S-0-0024 (command
values in the MDT) and S-0-0016 (feedback in the AT).  Each record begins with its word and two bytes of the service
channel.
"""

import struct
from collections.abc import Iterable, Mapping
from typing import Final, NamedTuple

from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.datum import IdnTable
from fieldrig_devices.sercos.idn import Format

CONFIGURED: Final = 7
HEAD_BYTES: Final = 4
"""Size of control or status word and service channel."""
AT_HEAD: Final = struct.Struct("<BHH")
"""Address, status word, service channel; the feedback values follow."""


class Telegrams(NamedTuple):
    """The IDNs in MDT and AT."""

    mdt: tuple[int, ...]
    at: tuple[int, ...]


STANDARD: Final[Mapping[int, Telegrams]] = {
    0: Telegrams((), ()),
    1: Telegrams((std.TORQUE_COMMAND,), ()),
    2: Telegrams((std.VELOCITY_COMMAND,), (std.VELOCITY_FEEDBACK,)),
    3: Telegrams((std.VELOCITY_COMMAND,), (std.POSITION_FEEDBACK_1,)),
    4: Telegrams((std.POSITION_COMMAND,), (std.POSITION_FEEDBACK_1,)),
    5: Telegrams((std.POSITION_COMMAND, std.VELOCITY_COMMAND), (std.POSITION_FEEDBACK_1, std.VELOCITY_FEEDBACK)),
    6: Telegrams((std.VELOCITY_COMMAND,), ()),
}
"""Standard telegrams by their number in S-0-0015."""

CODES: Final[Mapping[int, str]] = {
    std.VELOCITY_COMMAND: "i",
    std.ADDITIVE_VELOCITY_COMMAND: "i",
    std.VELOCITY_FEEDBACK: "i",
    std.POSITION_COMMAND: "i",
    std.ADDITIVE_POSITION_COMMAND: "i",
    std.POSITION_FEEDBACK_1: "i",
    std.POSITION_FEEDBACK_2: "i",
    std.TORQUE_COMMAND: "h",
    std.ADDITIVE_TORQUE_COMMAND: "h",
    std.TORQUE_FEEDBACK: "h",
    std.PROBE_1_POSITIVE: "i",
    std.PROBE_1_NEGATIVE: "i",
    std.PROBE_2_POSITIVE: "i",
    std.PROBE_2_NEGATIVE: "i",
    std.MASTER_CONTROL: "H",
    std.DRIVE_STATUS: "H",
    std.MEASURED_STATUS: "H",
    std.MANUFACTURER_CLASS_3: "H",
    std.FOLLOWING_DISTANCE: "i",
    std.VELOCITY_DEVIATION: "i",
    std.CLASS_1_DIAGNOSTIC: "H",
    std.CLASS_2_DIAGNOSTIC: "H",
    std.CLASS_3_DIAGNOSTIC: "H",
    std.DC_BUS_VOLTAGE: "h",
    std.MOTOR_TEMPERATURE: "h",
    std.AMPLIFIER_TEMPERATURE: "h",
    std.DIAGNOSTIC_NUMBER: "I",
}
"""Codes of cyclic data for `struct`, by IDN, for a master that knows the standard."""

_BY_BYTES: Final = {std.SERCOS_CYCLE_TIME: "h", std.TRANSMIT_RECEIVE_TIME: "i", std.COMMAND_VALID_TIME: "q"}


def code_of(table: IdnTable, idn: int) -> str:
    """Return the code of a value in a record, or "" if the drive has no such cyclic value."""
    if idn not in table:
        return ""
    attribute = table[idn].attribute
    if attribute.length.is_list or attribute.is_command:
        return ""
    code = _BY_BYTES[attribute.length.bytes]
    return code if attribute.format is Format.SIGNED else code.upper()


def record(codes: Iterable[str]) -> struct.Struct:
    """Return a record with word, service channel, and values of these codes."""
    return struct.Struct("<HH" + "".join(codes))


def size(codes: Iterable[str]) -> int:
    """Return the size of the values alone, in bytes."""
    return struct.calcsize("<" + "".join(codes))
