"""The scripts with which a drive reads its motor's encoder: type, serial number, position, and name plate.

`read_motor` reads everything.  Each kind of failure has a name; a drive shows all of them as 1117 (digest PD-171,
PD-172).
"""

from dataclasses import dataclass
from enum import Enum
from typing import Final

from fieldrig_devices.hiperface.conversation import AnsweredError, NoAnswerError, Request, Script
from fieldrig_devices.hiperface.memory import CREATED, WRITABLE, size_of, status_for
from fieldrig_devices.hiperface.plate import HEAD, NamePlate, PlateError, Wrong, plate_length
from fieldrig_devices.hiperface.shaft import BY_CODE, INCREMENTS
from fieldrig_devices.hiperface.telegram import (
    FACTORY_CODE,
    LARGEST_FIELD,
    SERIAL_LENGTH,
    Command,
    Status,
    about,
)

FIELD: Final = 0
"""Number of the data field with the plate."""
PORTION: Final = 32
"""Bytes read or stored per telegram, and so the loss when a telegram fails."""
BROKEN: Final = frozenset(
    {
        Status.ANALOG_SIGNALS,
        Status.ANGULAR_OFFSET,
        Status.PARTITION,
        Status.ANALOG_LIMITS,
        Status.I2C_BUS,
        Status.MEMORY_CHECKSUM,
    }
)
"""Status messages after which an encoder is not trusted."""
MOST_MESSAGES: Final = 8


class Failure(Enum):
    NO_ANSWER = "no encoder answers"
    UNREADABLE = "the encoder's memory cannot be read"
    MISSING = "the encoder has no name plate"
    CHECKSUM = "the name plate is damaged"
    FOREIGN = "the encoder contains other data, or is of an unknown type"
    SWAPPED = "the name plate belongs to another motor"


class MotorError(ValueError):
    def __init__(self, failure: Failure, detail: str = "") -> None:
        super().__init__(f"{failure.value}: {detail}" if detail else failure.value)
        self.failure = failure


@dataclass(frozen=True, slots=True)
class Identity:
    type_code: int
    serial_number: str
    version: str


@dataclass(frozen=True, slots=True)
class Motor:
    """The data that a drive has read from its motor."""

    encoder: Identity
    plate: NamePlate
    steps: int
    """Position when it was read, in steps."""


_OF_PLATE: Final = {
    Wrong.BLANK: Failure.MISSING,
    Wrong.FOREIGN: Failure.FOREIGN,
    Wrong.CHECKSUM: Failure.CHECKSUM,
    Wrong.VALUES: Failure.FOREIGN,
}


def read_motor(motor_type: str | None = None, serial_number: str | None = None) -> Script[Motor]:
    """Read the motor, and compare its type and serial number if they are given.  MotorError names a failure."""
    try:
        identity = yield from read_identity()
        messages = yield from read_messages()
        broken = [message for message in messages if message in BROKEN]
        if broken:
            raise MotorError(Failure.UNREADABLE, about(broken[0]))
        plate = yield from read_plate()
        steps = yield from read_position()
    except NoAnswerError as wrong:
        raise MotorError(Failure.UNREADABLE if wrong.has_heard else Failure.NO_ANSWER, str(wrong)) from wrong
    except AnsweredError as wrong:
        raise MotorError(Failure.UNREADABLE, str(wrong)) from wrong
    _check(identity, plate, motor_type, serial_number)
    return Motor(identity, plate, steps)


def _check(identity: Identity, plate: NamePlate, motor_type: str | None, serial_number: str | None) -> None:
    encoder_type = BY_CODE.get(identity.type_code)
    if encoder_type is None:
        raise MotorError(Failure.FOREIGN, f"type code {identity.type_code:02X}h")
    if plate.encoder_increments != INCREMENTS:
        raise MotorError(
            Failure.FOREIGN, f"its encoder counts {plate.encoder_increments} increments per turn; expected {INCREMENTS}"
        )
    if plate.is_multi_turn != (encoder_type.turns > 1):
        raise MotorError(Failure.SWAPPED, f"that motor has no encoder of type {identity.type_code:02X}h")
    for present, wanted in ((plate.type, motor_type), (plate.serial_number, serial_number)):
        if wanted is not None and present != wanted:
            raise MotorError(Failure.SWAPPED, f"found {present}, expected {wanted}")


def read_identity() -> Script[Identity]:
    label = yield Request(Command.TYPE_LABEL)
    number = yield Request(Command.SERIAL_NUMBER)
    serial, version = number[:SERIAL_LENGTH], number[SERIAL_LENGTH:]
    return Identity(label[1], _text(serial), _text(version))


def read_messages() -> Script[list[int]]:
    """Read the encoder's status messages since the last reading."""
    messages = list[int]()
    for _ in range(MOST_MESSAGES):
        (status,) = yield Request(Command.READ_STATUS)
        if status == Status.NO_ERROR:
            break
        messages.append(status)
    return messages


def read_position() -> Script[int]:
    """Read the position, in steps."""
    answer = yield Request(Command.READ_POSITION)
    return int.from_bytes(answer, "big")


def read_plate(code: int = FACTORY_CODE) -> Script[NamePlate]:
    """Read the plate.  Raises MotorError if there is none, or if it is invalid."""
    try:
        _, status = yield Request(Command.FIELD_STATUS, bytes((FIELD,)))
        data = yield from _read(0, HEAD.size, code)
        length = plate_length(data)
        if length > size_of(status):
            raise MotorError(Failure.FOREIGN, "its data field is too small")
        data += yield from _read(HEAD.size, length - HEAD.size, code)
        return NamePlate.decode(data)
    except PlateError as wrong:
        raise MotorError(_OF_PLATE[wrong.wrong], str(wrong)) from wrong
    except AnsweredError as wrong:
        failure = Failure.MISSING if wrong.status == Status.NO_FIELD else Failure.UNREADABLE
        raise MotorError(failure, str(wrong)) from wrong


def write_plate(plate: NamePlate, code: int = FACTORY_CODE) -> Script[None]:
    """Create the data field if needed, write the plate, and verify it.  AnsweredError if the encoder refuses."""
    yield from _prepare(code)
    data = plate.encode()
    yield from _store(0, b"\xff" * HEAD.size, code)  # an incomplete plate must not look valid
    yield from _store(HEAD.size, data[HEAD.size :], code)
    yield from _store(0, data[: HEAD.size], code)
    there = yield from read_plate(code)
    if there != plate:
        raise MotorError(Failure.CHECKSUM, "the plate that was read back differs from the one written")


def _prepare(code: int) -> Script[None]:
    try:
        _, status = yield Request(Command.FIELD_STATUS, bytes((FIELD,)))
        wanted = status & ~0x07 | status_for(LARGEST_FIELD, CREATED | WRITABLE) & 0x07
        if size_of(status) == LARGEST_FIELD:
            return
    except AnsweredError as wrong:
        if wrong.status != Status.NO_FIELD:
            raise
        wanted = status_for(LARGEST_FIELD)
    yield Request(Command.CREATE_FIELD, bytes((FIELD, wanted, code)))


def _store(address: int, data: bytes, code: int) -> Script[None]:
    for start in range(0, len(data), PORTION):
        portion = data[start : start + PORTION]
        yield Request(Command.STORE_DATA, bytes((FIELD, address + start, len(portion), code)) + portion)


def _read(address: int, count: int, code: int) -> Script[bytes]:
    data = b""
    while len(data) < count:
        portion = min(PORTION, count - len(data))
        answer = yield Request(Command.READ_DATA, bytes((FIELD, address + len(data), portion, code)))
        data += answer[3:]
    return data


def _text(data: bytes) -> str:
    return data.decode("latin-1").rstrip()
