"""HIPERFACE telegrams of the parameter channel: address, command, data, checksum.

The protocol is SICK STEGMANN's; its description is not available, so this module uses other publications:

- commands, their names, code 0 = 55h as delivered, temperature at channel 48h: SICK DME4000 operating instructions 9.7
- 9600 baud, 8E1, address 40h, broadcast FFh, XOR checksum, examples: wiki of Nilab (reverso encoder)
- status codes: SICK SEK34/SEL34 product information; B&R's help on ACOPOS error 7013; a counter at its end keeps its
  value, with an error: SICK HIPERFACE DSL manual 8.9
- lengths of 42h, 43h, 4Ah to 4Dh, 52h, bit 7 of the command, a refusal is the status telegram 50h, time-outs of a
  drive: two drives whose firmware is public (Phase Motion Control AxM-E, Servotronix CDHD); 44h, 46h, 4Bh and the rules
  of data fields: Kübler Sendix S36 manual 5.1.2

Our reading, where no source is available: the data of 4Eh, 4Fh, 55h, 56h and 57h (an answer repeats the request without
its codes), addresses 40h to 5Fh, and a broadcast is answered from the encoder's own address.
"""

from collections.abc import Mapping
from enum import IntEnum
from functools import reduce
from operator import xor
from typing import Final

from fieldrig.clock import MS

BROADCAST: Final = 0xFF
FACTORY_ADDRESS: Final = 0x40
ADDRESSES: Final = range(0x40, 0x60)
FACTORY_CODE: Final = 0x55
ERROR_BIT: Final = 0x80
"""Bit in the command of an answer: status messages are waiting."""
LARGEST_FIELD: Final = 128
TEMPERATURE: Final = 0x48
SINE, COSINE = 0x00, 0x01  # channels of 44h, as Nilab's encoder has them
SERIAL_LENGTH, VERSION_LENGTH = 9, 20  # characters of 56h


class Command(IntEnum):
    READ_POSITION = 0x42
    SET_POSITION = 0x43
    READ_ANALOG = 0x44
    READ_COUNTER = 0x46
    INCREASE_COUNTER = 0x47
    CLEAR_COUNTER = 0x49
    READ_DATA = 0x4A
    STORE_DATA = 0x4B
    FIELD_STATUS = 0x4C
    CREATE_FIELD = 0x4D
    AVAILABLE_MEMORY = 0x4E
    CHANGE_CODE = 0x4F
    READ_STATUS = 0x50
    TYPE_LABEL = 0x52
    RESET = 0x53
    ALLOCATE_ADDRESS = 0x55
    SERIAL_NUMBER = 0x56
    CONFIGURE_SERIAL = 0x57


class Status(IntEnum):
    NO_ERROR = 0x00
    ANALOG_SIGNALS = 0x01
    ANGULAR_OFFSET = 0x02
    PARTITION = 0x03
    ANALOG_LIMITS = 0x04
    I2C_BUS = 0x05
    MEMORY_CHECKSUM = 0x06
    WATCHDOG = 0x07
    COUNTER = 0x08
    PARITY = 0x09
    CHECKSUM = 0x0A
    COMMAND = 0x0B
    LENGTH = 0x0C
    ARGUMENT = 0x0D
    WRITE_PROTECTED = 0x0E
    ACCESS_CODE = 0x0F
    FIELD_SIZE = 0x10
    ADDRESS = 0x11
    NO_FIELD = 0x12
    TEMPERATURE = 0x1E
    SPEED = 0x1F
    SINGLE_TURN = 0x20
    MULTI_TURN = 0x21


ABOUT: Final[Mapping[int, str]] = {
    Status.NO_ERROR: "no error",
    Status.ANALOG_SIGNALS: "analog signals out of their range",
    Status.ANGULAR_OFFSET: "internal angular offset wrong",
    Status.PARTITION: "table of the data fields damaged",
    Status.ANALOG_LIMITS: "analog limits not available",
    Status.I2C_BUS: "bus to the memory out of order",
    Status.MEMORY_CHECKSUM: "checksum of the memory wrong",
    Status.WATCHDOG: "reset by the program's watchdog",
    Status.COUNTER: "counter at its end",
    Status.PARITY: "parity error",
    Status.CHECKSUM: "checksum of the telegram wrong",
    Status.COMMAND: "unknown command",
    Status.LENGTH: "wrong number of data",
    Status.ARGUMENT: "an argument that is not allowed",
    Status.WRITE_PROTECTED: "this data field must not be written",
    Status.ACCESS_CODE: "wrong access code",
    Status.FIELD_SIZE: "the size of this data field cannot be changed",
    Status.ADDRESS: "beyond the data field",
    Status.NO_FIELD: "no such data field",
    Status.TEMPERATURE: "encoder too hot",
    Status.SPEED: "too fast, no position",
    Status.SINGLE_TURN: "single-turn position unreliable",
    Status.MULTI_TURN: "multi-turn position wrong",
}

REQUEST_DATA: Final[Mapping[int, int]] = {
    Command.READ_POSITION: 0,
    Command.SET_POSITION: 5,  # position, code 0
    Command.READ_ANALOG: 1,  # channel
    Command.READ_COUNTER: 0,
    Command.INCREASE_COUNTER: 0,
    Command.CLEAR_COUNTER: 1,  # code 0
    Command.READ_DATA: 4,  # field, address, count, code
    Command.STORE_DATA: 4,  # the same, and `count` more
    Command.FIELD_STATUS: 1,  # field
    Command.CREATE_FIELD: 3,  # field, status, code
    Command.AVAILABLE_MEMORY: 0,
    Command.CHANGE_CODE: 3,  # number, old, new
    Command.READ_STATUS: 0,
    Command.TYPE_LABEL: 0,
    Command.RESET: 0,
    Command.ALLOCATE_ADDRESS: 2,  # address, code 0
    Command.SERIAL_NUMBER: 0,
    Command.CONFIGURE_SERIAL: 2,  # Mode_485, code 0
}
"""Number of bytes between command and checksum of a request."""

ANSWER_DATA: Final[Mapping[int, int]] = {
    Command.READ_POSITION: 4,
    Command.SET_POSITION: 0,
    Command.READ_ANALOG: 3,  # channel, value
    Command.READ_COUNTER: 3,
    Command.INCREASE_COUNTER: 0,
    Command.CLEAR_COUNTER: 0,
    Command.READ_DATA: 3,  # field, address, count, and `count` more
    Command.STORE_DATA: 3,
    Command.FIELD_STATUS: 2,  # field, status
    Command.CREATE_FIELD: 2,
    Command.AVAILABLE_MEMORY: 3,  # free bytes, number of fields
    Command.CHANGE_CODE: 1,  # number
    Command.READ_STATUS: 1,
    Command.TYPE_LABEL: 4,  # Mode_485, type, size of the memory in 16 bytes, options
    Command.ALLOCATE_ADDRESS: 1,
    Command.SERIAL_NUMBER: SERIAL_LENGTH + VERSION_LENGTH,
    Command.CONFIGURE_SERIAL: 1,
}
"""Number of bytes between command and checksum of an answer; a reset has no answer."""

LONGEST_NS: Final[Mapping[int, int]] = {
    Command.SET_POSITION: 90 * MS,
    Command.STORE_DATA: 250 * MS,
    Command.CREATE_FIELD: 250 * MS,
    Command.CHANGE_CODE: 250 * MS,
    Command.INCREASE_COUNTER: 250 * MS,
    Command.CLEAR_COUNTER: 250 * MS,
    Command.ALLOCATE_ADDRESS: 250 * MS,
    Command.CONFIGURE_SERIAL: 250 * MS,
}
"""Longest time from the end of a request to the start of its answer; `QUERY_NS` for other commands."""
QUERY_NS: Final = 25 * MS


def checksum(data: bytes) -> int:
    return reduce(xor, data, 0)


def framed(address: int, command: int, data: bytes = b"") -> bytes:
    body = bytes((address, command)) + data
    return body + bytes((checksum(body),))


def request_length(head: bytes | bytearray) -> int | None:
    """Return the length of the request that begins with `head`, with checksum, or None while it is unknown."""
    data = REQUEST_DATA.get(head[1]) if len(head) > 1 else None
    if data is None:
        return None
    if head[1] == Command.STORE_DATA:
        return 3 + data + head[4] if len(head) > 4 else None
    return 3 + data


def answer_length(head: bytes | bytearray) -> int | None:
    """Return the length of the answer that begins with `head`, with checksum, or None while it is unknown."""
    data = ANSWER_DATA.get(head[1] & ~ERROR_BIT) if len(head) > 1 else None
    if data is None:
        return None
    if head[1] & ~ERROR_BIT == Command.READ_DATA:
        return 3 + data + head[4] if len(head) > 4 else None
    return 3 + data


def longest_ns(command: int) -> int:
    return LONGEST_NS.get(command, QUERY_NS)


def about(status: int) -> str:
    return ABOUT.get(status, "an unknown status")
