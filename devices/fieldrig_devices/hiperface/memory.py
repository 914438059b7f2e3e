"""The encoder's EEPROM: data fields, access codes, counter, address, format of the line, offset of the position.

Rules of data fields after Kübler Sendix S36 manual 5.1.2.8 to 5.1.2.10 and the drives named in `telegram`: fields are
created in sequence, in blocks of 16 bytes up to 128; bit 3 of a field's status requires an access code, and bits 5-4
select one of four; only the last field can be resized or deleted, and deletion has to repeat its status.  Our choice: a
new field is filled with FFh, like erased memory; 1792 bytes are free (SICK SEK34).
"""

import struct
from dataclasses import dataclass, field
from typing import ClassVar, Final, Self

from fieldrig_devices.hiperface import mode
from fieldrig_devices.hiperface.telegram import ADDRESSES, FACTORY_ADDRESS, FACTORY_CODE, Status

FREE: Final = 1792  # bytes
BLOCK: Final = 16  # bytes
SIZE_IN_BLOCKS: Final = 128
"""Size of the whole memory with the encoder's own part, as in the type label."""
BLANK: Final = 0xFF
CREATED, WRITABLE, CODED = 0x80, 0x40, 0x08  # bits of a field's status
_OWN_CODE, _BLOCKS = 0x30, 0x07  # masks
COUNTS: Final = 1 << 24
FACTORY_MODE: Final = 0xE4


class RefusedError(Exception):
    """The encoder refuses a request; `status` is the reason."""

    def __init__(self, status: Status) -> None:
        super().__init__(status.name)
        self.status = status


@dataclass(slots=True)
class Field:
    status: int
    data: bytearray

    @property
    def code(self) -> int | None:
        """Number of its access code, or None if it requires none."""
        return (self.status & _OWN_CODE) >> 4 if self.status & CODED else None


def size_of(status: int) -> int:
    """Return the size of a field with this status, in bytes."""
    return ((status & _BLOCKS) + 1) * BLOCK


def status_for(size: int, flags: int = CREATED | WRITABLE | CODED) -> int:
    """Return the status of a field of `size` bytes, a multiple of 16 up to 128."""
    return flags | size // BLOCK - 1


@dataclass(slots=True)
class Eeprom:
    address: int = FACTORY_ADDRESS
    mode: int = FACTORY_MODE
    counter: int = 0
    offset: int = 0
    """Steps from the shaft to the reported position."""
    codes: bytearray = field(default_factory=lambda: bytearray((FACTORY_CODE,) * 4))
    fields: list[Field] = field(default_factory=list)

    _HEAD: ClassVar = struct.Struct(">4sBBIi4sB")
    _MAGIC: ClassVar = b"HFM1"

    @property
    def free(self) -> int:
        return FREE - sum(len(field.data) for field in self.fields)

    def field(self, number: int) -> Field:
        if number >= len(self.fields):
            raise RefusedError(Status.NO_FIELD)
        return self.fields[number]

    def check_code(self, number: int, given: int) -> None:
        if self.codes[number] != given:
            raise RefusedError(Status.ACCESS_CODE)

    def read(self, number: int, address: int, count: int, code: int) -> bytes:
        return bytes(self._range(number, address, count, code).data[address : address + count])

    def store(self, number: int, address: int, data: bytes, code: int) -> None:
        field = self._range(number, address, len(data), code)
        if not field.status & WRITABLE:
            raise RefusedError(Status.WRITE_PROTECTED)
        field.data[address : address + len(data)] = data

    def create(self, number: int, status: int, code: int) -> None:
        """Create, change or delete a field."""
        if number > len(self.fields):
            raise RefusedError(Status.NO_FIELD)
        if number < len(self.fields):
            self._change(number, status, code)
        elif not status & CREATED:
            raise RefusedError(Status.NO_FIELD)
        elif size_of(status) > self.free:
            raise RefusedError(Status.ARGUMENT)
        else:
            new = Field(status, bytearray((BLANK,) * size_of(status)))
            self._check(new, code)
            self.fields.append(new)

    def change_code(self, number: int, old: int, new: int) -> None:
        if number >= len(self.codes):
            raise RefusedError(Status.ARGUMENT)
        self.check_code(number, old)
        self.codes[number] = new

    def _range(self, number: int, address: int, count: int, code: int) -> Field:
        field = self.field(number)
        self._check(field, code)
        if address + count > len(field.data):
            raise RefusedError(Status.ADDRESS)
        return field

    def _check(self, field: Field, code: int) -> None:
        if field.code is not None:
            self.check_code(field.code, code)

    def _change(self, number: int, status: int, code: int) -> None:
        field = self.fields[number]
        self._check(field, code)
        is_last = number == len(self.fields) - 1
        if not status & CREATED:
            self._delete(field, status, is_last)
            return
        size = size_of(status)
        if size != len(field.data):
            if not is_last or size > self.free + len(field.data):
                raise RefusedError(Status.FIELD_SIZE)
            field.data = field.data[:size] + bytearray((BLANK,) * (size - len(field.data)))
        field.status = status

    def _delete(self, field: Field, status: int, is_last: bool) -> None:
        if not is_last:
            raise RefusedError(Status.FIELD_SIZE)
        if status != field.status & ~CREATED:
            raise RefusedError(Status.ARGUMENT)
        self.fields.pop()

    def encode(self) -> bytes:
        head = self._HEAD.pack(
            self._MAGIC, self.address, self.mode, self.counter, self.offset, bytes(self.codes), len(self.fields)
        )
        return head + b"".join(bytes((field.status,)) + field.data for field in self.fields)

    def become(self, other: "Eeprom") -> None:
        """Take over the content of another memory, which must not be used afterwards."""
        self.address, self.mode, self.counter, self.offset = other.address, other.mode, other.counter, other.offset
        self.codes, self.fields = other.codes, other.fields

    @classmethod
    def decode(cls, body: bytes) -> Self:
        """Return the memory of encoded data.  Raises ValueError for data that `encode` does not write."""
        try:
            magic, address, mode_, counter, offset, codes, count = cls._HEAD.unpack_from(body)
            eeprom = cls(address, mode_, counter, offset, bytearray(codes))
            place = cls._HEAD.size
            for _ in range(count):
                size = size_of(body[place])
                eeprom.fields.append(Field(body[place], bytearray(body[place + 1 : place + 1 + size])))
                place += 1 + size
        except (struct.error, IndexError) as cause:
            raise ValueError("the data are incomplete") from cause
        is_sound = address in ADDRESSES and mode.is_right(mode_) and eeprom.free >= 0 and counter < COUNTS
        if magic != cls._MAGIC or place != len(body) or not is_sound:
            raise ValueError("the data are not the memory of an encoder")
        return eeprom
