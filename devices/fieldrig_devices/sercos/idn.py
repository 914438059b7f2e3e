"""Identification numbers, and the seven elements of the operation datum behind each.

Source: IEC 61491 by its public facts (structure of IDNs, attribute, service channel error messages).  A number with bit
15 is a manufacturer's (P), bits 12 to 14 are the parameter set.  Numbers go over the ring low byte first; texts and
lists are led by their actual and largest length in bytes.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

MANUFACTURER: Final = 0x8000
ALL_PHASES: Final = (2, 3, 4)


def s(number: int) -> int:
    """A standard IDN, S-0-`number`."""
    return number


def p(number: int) -> int:
    """A manufacturer's IDN, P-0-`number`."""
    return MANUFACTURER | number


def idn_text(idn: int) -> str:
    return f"{'P' if idn & MANUFACTURER else 'S'}-{idn >> 12 & 7}-{idn & 0xFFF:04}"


def idn_of(text: str) -> int:
    """The inverse of `idn_text`; ValueError for anything else."""
    found = re.fullmatch(r"([SP])-([0-7])-(\d{1,4})", text.upper(), re.ASCII)
    if found is None or int(found[3]) > 0xFFF:
        raise ValueError(f"{text!r} is no IDN: write it like S-0-0047 or P-0-0010")
    return (MANUFACTURER if found[1] == "P" else 0) | int(found[2]) << 12 | int(found[3])


class Element(IntEnum):
    """Of an operation datum, as the control word names it."""

    CLOSED = 0
    IDN = 1
    NAME = 2
    ATTRIBUTE = 3
    UNIT = 4
    MINIMUM = 5
    MAXIMUM = 6
    DATA = 7


class Code(IntEnum):
    """Service channel error messages."""

    CHANNEL_CLOSED = 0x0001
    NO_IDN = 0x1001
    WRONG_ACCESS = 0x1009
    NO_NAME = 0x2001
    NAME_READ_ONLY = 0x2004
    ATTRIBUTE_READ_ONLY = 0x3004
    NO_UNIT = 0x4001
    UNIT_READ_ONLY = 0x4004
    NO_MINIMUM = 0x5001
    MINIMUM_READ_ONLY = 0x5004
    NO_MAXIMUM = 0x6001
    MAXIMUM_READ_ONLY = 0x6004
    TOO_SHORT = 0x7002
    TOO_LONG = 0x7003
    READ_ONLY = 0x7004
    PROTECTED_NOW = 0x7005
    BELOW_MINIMUM = 0x7006
    ABOVE_MAXIMUM = 0x7007
    INVALID = 0x7008
    COMMAND_ACTIVE = 0x700B
    COMMAND_IMPOSSIBLE = 0x700C


class ServiceError(Exception):
    """What a drive answers in place of data."""

    def __init__(self, code: int) -> None:
        super().__init__(f"service channel error {code:04X}h")
        self.code = code


class Length(IntEnum):
    """Of the data, as the attribute has it."""

    TWO = 1
    FOUR = 2
    EIGHT = 3
    LIST_OF_BYTES = 4
    LIST_OF_WORDS = 5
    LIST_OF_DOUBLE_WORDS = 6
    LIST_OF_QUADRUPLE_WORDS = 7

    @property
    def is_list(self) -> bool:
        return self >= Length.LIST_OF_BYTES

    @property
    def bytes(self) -> int:
        """Of one number."""
        return (0, 2, 4, 8, 1, 2, 4, 8)[self]


class Format(IntEnum):
    """How data is shown."""

    BINARY = 0
    UNSIGNED = 1
    SIGNED = 2
    HEX = 3
    TEXT = 4
    IDN = 5
    FLOAT = 6


@dataclass(frozen=True, slots=True)
class Attribute:
    """The third element."""

    length: Length
    format: Format = Format.UNSIGNED
    decimals: int = 0
    factor: int = 1
    is_command: bool = False
    protected: tuple[int, ...] = ()
    """The phases in which the data can't be written; all of them: never."""

    @property
    def word(self) -> int:
        word = self.factor | self.length << 16 | self.is_command << 19 | self.format << 20 | self.decimals << 24
        for phase in self.protected:
            word |= 1 << 26 + phase
        return word

    @classmethod
    def of(cls, word: int) -> "Attribute":
        """Of what was read from a drive.  ValueError for lengths and formats that the standard doesn't know."""
        return cls(
            Length(word >> 16 & 7),
            Format(word >> 20 & 7),
            word >> 24 & 15,
            word & 0xFFFF,
            bool(word >> 19 & 1),
            tuple(phase for phase in ALL_PHASES if word >> 26 + phase & 1),
        )


READ_ONLY: Final = ALL_PHASES


class Datum:
    """One operation datum.  Numbers are kept as bytes, as they go over the ring."""

    __slots__ = (
        "attribute", "data", "idn", "largest", "maximum", "minimum", "name", "reader", "status", "unit", "watchers",
        "writer",
    )  # fmt: skip

    def __init__(
        self,
        idn: int,
        name: str,
        attribute: Attribute,
        value: int | str | Iterable[int] = 0,
        *,
        unit: str = "",
        minimum: int | None = None,
        maximum: int | None = None,
        largest: int = 256,
    ) -> None:
        """`largest` is the length in bytes that a list or text may have."""
        self.idn, self.name, self.attribute, self.unit = idn, name, attribute, unit
        self.minimum, self.maximum, self.largest = minimum, maximum, largest
        self.status = 0
        """The first element: what became of a procedure command."""
        self.reader: Callable[[], bytes] | None = None
        """Gives the data in place of `data`; may raise ServiceError."""
        self.writer: Callable[[bytes], None] | None = None
        """Takes what the master writes, within limits, in place of `data`; may raise ServiceError."""
        self.watchers: list[Callable[[], None]] = []
        """Called after each write by the master."""
        self.data = self.encoded(value)

    @property
    def is_signed(self) -> bool:
        return self.attribute.format is Format.SIGNED

    def encoded(self, value: int | str | Iterable[int]) -> bytes:
        if isinstance(value, str):
            return value.encode("latin-1", "replace")[: self.largest]
        size = self.attribute.length.bytes
        numbers = (value,) if isinstance(value, int) else value
        if isinstance(value, int) and self.attribute.length.is_list:
            numbers = ()
        return b"".join((number & (1 << 8 * size) - 1).to_bytes(size, "little") for number in numbers)

    def decoded(self, data: bytes) -> list[int]:
        size = self.attribute.length.bytes
        starts = range(0, len(data) - size + 1, size)
        return [int.from_bytes(data[at : at + size], "little", signed=self.is_signed) for at in starts]

    @property
    def number(self) -> int:
        return int.from_bytes(self.present(), "little", signed=self.is_signed)

    @property
    def numbers(self) -> list[int]:
        return self.decoded(self.present())

    @property
    def text(self) -> str:
        return self.present().decode("latin-1")

    def set(self, value: int | str | Iterable[int]) -> None:
        """By the drive itself: no limit and no protection holds."""
        self.data = self.encoded(value)

    def present(self) -> bytes:
        return self.data if self.reader is None else self.reader()

    def element(self, element: Element) -> bytes:
        """As it goes over the ring.  ServiceError if there is no such element."""
        match element:
            case Element.IDN:
                return self.status.to_bytes(2, "little")
            case Element.NAME:
                return self._text(self.name, Code.NO_NAME)
            case Element.ATTRIBUTE:
                return self.attribute.word.to_bytes(4, "little")
            case Element.UNIT:
                return self._text(self.unit, Code.NO_UNIT)
            case Element.MINIMUM:
                return self._limit(self.minimum, Code.NO_MINIMUM)
            case Element.MAXIMUM:
                return self._limit(self.maximum, Code.NO_MAXIMUM)
            case Element.DATA:
                data = self.present()
                return led(data, self.largest) if self.attribute.length.is_list else data
        raise ServiceError(Code.WRONG_ACCESS)

    @staticmethod
    def _text(text: str, missing: Code) -> bytes:
        if not text:
            raise ServiceError(missing)
        return led(text.encode("latin-1", "replace"), len(text))

    def _limit(self, limit: int | None, missing: Code) -> bytes:
        if limit is None:
            raise ServiceError(missing)
        size = self.attribute.length.bytes
        return (limit & (1 << 8 * size) - 1).to_bytes(size, "little")

    def write(self, data: bytes, phase: int) -> None:
        """By the master, as it came over the ring.  ServiceError says why not."""
        if self.attribute.protected == READ_ONLY:
            raise ServiceError(Code.READ_ONLY)
        if phase in self.attribute.protected:
            raise ServiceError(Code.PROTECTED_NOW)
        data = self._checked(data)
        if self.writer is not None:
            self.writer(data)
        else:
            self.data = data
        for watcher in self.watchers:
            watcher()

    def _checked(self, data: bytes) -> bytes:
        if self.attribute.length.is_list:
            return self._checked_list(data)
        size = self.attribute.length.bytes
        if len(data) != size:
            raise ServiceError(Code.TOO_SHORT if len(data) < size else Code.TOO_LONG)
        self._check_limits(self.decoded(data))
        return data

    def _checked_list(self, data: bytes) -> bytes:
        if len(data) < 4:
            raise ServiceError(Code.TOO_SHORT)
        actual = int.from_bytes(data[:2], "little")
        if actual > self.largest:
            raise ServiceError(Code.TOO_LONG)
        if len(data) < 4 + actual or actual % self.attribute.length.bytes:
            raise ServiceError(Code.TOO_SHORT)
        data = data[4 : 4 + actual]
        if self.attribute.format is not Format.TEXT:
            self._check_limits(self.decoded(data))
        return data

    def _check_limits(self, numbers: list[int]) -> None:
        for number in numbers:
            if self.minimum is not None and number < self.minimum:
                raise ServiceError(Code.BELOW_MINIMUM)
            if self.maximum is not None and number > self.maximum:
                raise ServiceError(Code.ABOVE_MAXIMUM)


def led(data: bytes, largest: int) -> bytes:
    """A list or text behind its actual and largest length."""
    return len(data).to_bytes(2, "little") + largest.to_bytes(2, "little") + data


class IdnTable:
    """The operation data of one drive."""

    def __init__(self, data: Iterable[Datum] = ()) -> None:
        self._data: dict[int, Datum] = {}
        for datum in data:
            self.add(datum)

    def add(self, datum: Datum) -> Datum:
        self._data[datum.idn] = datum
        return datum

    def __getitem__(self, idn: int) -> Datum:
        return self._data[idn]

    def __contains__(self, idn: object) -> bool:
        return idn in self._data

    def __iter__(self) -> Iterator[Datum]:
        return iter(self._data.values())

    def asked(self, idn: int) -> Datum:
        """ServiceError if there is none."""
        datum = self._data.get(idn)
        if datum is None:
            raise ServiceError(Code.NO_IDN)
        return datum


class Command:
    """A procedure command: the master sets it to 3, then its status tells how it goes."""

    CLEARED, DONE, INTERRUPTED, ACTIVE, FAILED = 0x0, 0x3, 0x5, 0x7, 0xF

    def __init__(
        self,
        datum: Datum,
        start: Callable[["Command"], None],
        on_change: Callable[[bool], None],
        cancel: Callable[[], None] | None = None,
    ) -> None:
        """`start` ends, now or later, with `finish`; it may raise ServiceError.

        `on_change` tells whether the command has ended and is not yet cleared.
        """
        self._datum, self._start, self._on_change, self._cancel = datum, start, on_change, cancel
        datum.writer = self._write

    @property
    def is_active(self) -> bool:
        return self._datum.status == self.ACTIVE

    def finish(self, *, is_good: bool = True) -> None:
        if self.is_active:
            self._datum.status = self.DONE if is_good else self.FAILED
            self._on_change(True)

    def _write(self, data: bytes) -> None:
        match data[0] & 3:
            case 3:
                if self.is_active:
                    raise ServiceError(Code.COMMAND_ACTIVE)
                self._datum.data, self._datum.status = data, self.ACTIVE
                self._start(self)
            case 1:
                self._datum.data, self._datum.status = data, self.INTERRUPTED
            case _:
                if self.is_active and self._cancel is not None:
                    self._cancel()
                self._datum.data, self._datum.status = data, self.CLEARED
                self._on_change(False)
