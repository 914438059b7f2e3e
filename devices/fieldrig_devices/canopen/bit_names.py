"""The names of the bits of objects that are sets of bits.

Source: CiA 402-2 (IEC 61800-7-201), tables of controlword, statusword and digital inputs, whose bits 4 to 6, 9, 12 and
13 depend on the mode of operation; CiA 301 version 4.2, table 39 (error register).
"""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.canopen.emcy_words import REGISTER_BITS
from fieldrig_devices.canopen.variable import Variable
from fieldrig_devices.drive_profile.objects import of_first_axis

CONTROLWORD: Final = {
    0: "switch on", 1: "enable voltage", 2: "quick stop", 3: "enable operation", 4: "operation mode specific",
    5: "operation mode specific", 6: "operation mode specific", 7: "fault reset", 8: "halt",
    9: "operation mode specific", 10: "reserved", 11: "manufacturer-specific", 12: "manufacturer-specific",
    13: "manufacturer-specific", 14: "manufacturer-specific", 15: "manufacturer-specific",
}  # fmt: skip
STATUSWORD: Final = {
    0: "ready to switch on", 1: "switched on", 2: "operation enabled", 3: "fault", 4: "voltage enabled",
    5: "quick stop", 6: "switch on disabled", 7: "warning", 8: "manufacturer-specific", 9: "remote",
    10: "target reached", 11: "internal limit active", 12: "operation mode specific", 13: "operation mode specific",
    14: "manufacturer-specific", 15: "manufacturer-specific",
}  # fmt: skip
DIGITAL_INPUTS: Final = {0: "negative limit switch", 1: "positive limit switch", 2: "home switch", 3: "interlock"}
ERROR_REGISTER: Final = {bit: name or "reserved" for bit, name in enumerate(REGISTER_BITS)}
# By index of the first axis; the objects of the n-th axis are 800h further on (CiA 402-2).
_OF_PROFILE: Final = {
    0x6040: ("control", CONTROLWORD),
    0x6041: ("status", STATUSWORD),
    0x60FD: ("input", DIGITAL_INPUTS),
}
_NONE: Final[Mapping[int, str]] = {}


def bits_of(variable: Variable) -> Mapping[int, str]:
    """Return the names of the bits of an object; none if it is a number, or an object of another profile."""
    index = variable.index
    if index == 0x1001:
        return ERROR_REGISTER
    word, names = _OF_PROFILE.get(of_first_axis(index) or 0, ("", _NONE))
    return names if word and word in variable.name.lower() else _NONE
