"""The data types of the library, with their IEC names and values (SCU-092, digest 3)."""

from collections.abc import Mapping
from enum import IntEnum
from typing import Final


class ErrorId(IntEnum):
    """PTOPWM_ERR_TYPE: the type of error on the pin ErrID (SCU-060)."""

    NO_ERROR = 0x00
    PTO_UNKNOW_REF = 0x01
    """Unknown reference, or a channel that is not configured for the block."""
    PTO_UNKNOW_PARAMETER = 0x02
    PTO_INVALID_PARAMETER = 0x03
    PTO_COM_ERROR = 0x04
    PTO_AXIS_ERROR = 0x05


class Direction(IntEnum):
    """PTO_DIRECTION."""

    PTO_POSITIVE = 0x00
    PTO_NEGATIVE = 0x01
    PTO_CURRENT = 0x02
    """The direction of the last move."""


class Parameter(IntEnum):
    """PTO_PARAMETER_TYPE: the parameters that a program may change (SCU-056)."""

    PTO_START_FREQUENCY = 0x00
    PTO_STOP_FREQUENCY = 0x01


ENUMERATIONS: Final[Mapping[str, Mapping[str, int]]] = {
    "PTOPWM_ERR_TYPE": {member.name: member.value for member in ErrorId},
    "PTO_DIRECTION": {member.name: member.value for member in Direction},
    "PTO_PARAMETER_TYPE": {member.name: member.value for member in Parameter},
}
"""The enumerations as an IEC program declares them.  Their base type is BYTE, like that of PTO_REF."""

ALIASES: Final[Mapping[str, str]] = {
    "PTO_NO_ERROR": "NO_ERROR",
    "PTO_UNKNOWN_REF": "PTO_UNKNOW_REF",
    "PTO_UNKNOWN_PARAMETER": "PTO_UNKNOW_PARAMETER",
    "PTO_UNKOWN_PARAMETER": "PTO_UNKNOW_PARAMETER",
    "PTO_DIRECTION_TYPE": "PTO_DIRECTION",
    "PTO_REF_TYPE": "PTO_REF",
}
"""Other spellings in the manual, of members and of types, and the name that each means (S-20)."""
