"""SDO abort codes, and the exception that refuses an access with such a code.

Source: CiA 301 table 22.
"""

from enum import IntEnum


class Code(IntEnum):
    TOGGLE_BIT_NOT_ALTERNATED = 0x0503_0000
    PROTOCOL_TIMED_OUT = 0x0504_0000
    UNKNOWN_COMMAND_SPECIFIER = 0x0504_0001
    INVALID_BLOCK_SIZE = 0x0504_0002
    INVALID_SEQUENCE_NUMBER = 0x0504_0003
    CRC_ERROR = 0x0504_0004
    OUT_OF_MEMORY = 0x0504_0005
    UNSUPPORTED_ACCESS = 0x0601_0000
    WRITE_ONLY = 0x0601_0001
    READ_ONLY = 0x0601_0002
    NO_OBJECT = 0x0602_0000
    NOT_MAPPABLE = 0x0604_0041
    PDO_LENGTH_EXCEEDED = 0x0604_0042
    PARAMETER_INCOMPATIBLE = 0x0604_0043
    HARDWARE = 0x0606_0000
    LENGTH_MISMATCH = 0x0607_0010
    LENGTH_TOO_HIGH = 0x0607_0012
    LENGTH_TOO_LOW = 0x0607_0013
    NO_SUB_INDEX = 0x0609_0011
    INVALID_VALUE = 0x0609_0030
    VALUE_TOO_HIGH = 0x0609_0031
    VALUE_TOO_LOW = 0x0609_0032
    GENERAL = 0x0800_0000
    NOT_STORED = 0x0800_0020
    DEVICE_STATE = 0x0800_0022
    NO_DATA = 0x0800_0024


NAMES = {int(code): code.name for code in Code}


class Abort(Exception):  # noqa: N818 - the standard's word for it
    """An access is refused with `code`, which is one of `Code` or any code that another node has sent."""

    def __init__(self, code: int) -> None:
        super().__init__(f"{code:08X}h {NAMES.get(code, 'an unknown code')}")
        self.code = code
