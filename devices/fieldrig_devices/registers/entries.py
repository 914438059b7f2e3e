"""The entries of a register table: bits, registers with their fields, and queues, each checked by itself."""

import math
import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.settings import Settings
from fieldrig_devices.registers.form import FORMATS, TYPE_PATTERN, ByteOrder, Form, WordOrder, characters_in, words_in
from fieldrig_devices.registers.type_names import naming
from fieldrig_devices.sources.settings import SourceSettings

Value = bool | int | float | str
Number = int | float
MOST_EXPONENT: Final = 30
Access = Literal["ro", "rw", "wo"]
Direction = Literal["from_wire", "to_wire"]
Address = Annotated[int, Field(ge=0, le=0xFFFF)]
Name = Annotated[
    str,
    Field(
        pattern=r"^[A-Za-z_][A-Za-z0-9_.-]*$",
        description="a name of letters, digits, _, . and -, beginning with a letter or _",
    ),
]


class Bit(Settings):
    """One coil or discrete input, or `count` of them starting at `address`."""

    address: Address
    name: Name
    initial: bool = False
    access: Access | None = Field(
        default=None, description="access of clients; default rw for coils, ro for discrete inputs"
    )
    wire: str | None = Field(default=None, description="a digital signal")
    direction: Direction | None = None
    retained: bool = Field(default=False, description="kept in non-volatile memory")
    source: SourceSettings | None = Field(default=None, description="a value that lives by itself")
    count: int = Field(default=1, ge=1, le=65536, description="number of identical entries, named name.0, name.1, ...")
    about: str = ""

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_common(self)
        return self


class BitField(Settings):
    """Some adjacent bits of a register, with a name of their own."""

    bit: int = Field(ge=0, le=63, description="position of the lowest bit; 0 is the lowest of the value")
    width: int = Field(default=1, ge=1, le=64, description="number of bits; a single one is true or false")
    name: Name
    values: dict[int, str] = Field(
        default_factory=dict, description="names of the numbers, such as {0: off, 1: heating}"
    )
    wire: str | None = Field(default=None, description="a signal without unit; digital for a single bit")
    direction: Direction | None = None
    about: str = ""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.wire is None and self.direction is not None:
            raise ValueError("direction: expected a wire beside it")
        if self.values and self.width == 1:
            raise ValueError("values: expected a width of at least 2, because a single bit is true or false")
        _check_names(self.values, 0, (1 << self.width) - 1)
        return self

    @property
    def mask(self) -> int:
        """The bits of the field in the number of its register."""
        return (1 << self.width) - 1 << self.bit


class Register(Settings):
    """One value in holding or input registers, or `count` of them starting at `address`."""

    address: Address
    name: Name
    type: Annotated[str, naming("bool", *FORMATS, "string[n]")] = Field(
        default="u16",
        pattern=TYPE_PATTERN,
        description="bool, u16, s16, u32, s32, u64, s64, f32, f64, bcd16, bcd32, or string[n] of n characters, "
        "two per register",
    )
    unit: str = ""
    access: Access | None = Field(
        default=None, description="access of clients; default rw for holding registers, ro for input registers"
    )
    scale: Number = 1
    offset: Number = 0
    factor_from: Name | None = Field(default=None, description="name of a register that multiplies the scale")
    exponent_from: Name | None = Field(
        default=None, description="name of a register whose value n multiplies the scale by 10^n, as in SunSpec"
    )
    values: dict[int, str] = Field(
        default_factory=dict, description="names of the numbers, such as {0: off, 1: heating}"
    )
    bits: list[BitField] = Field(default_factory=list, description="named bits of the value")
    initial: Value | None = None
    min: Number | None = None
    max: Number | None = None
    word_order: WordOrder | None = Field(
        default=None, description="big: the high word first; default: that of the table"
    )
    byte_order: ByteOrder | None = Field(
        default=None, description="big: the high byte of each register first; default: that of the table"
    )
    wire: str | None = Field(default=None, description="a signal in the same unit")
    direction: Direction | None = None
    retained: bool = Field(default=False, description="kept in non-volatile memory")
    source: SourceSettings | None = Field(default=None, description="a value that lives by itself")
    count: int = Field(default=1, ge=1, le=65536, description="number of identical entries, named name.0, name.1, ...")
    about: str = ""

    @property
    def words(self) -> int:
        """Number of registers of one value."""
        return words_in(self.type)

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_common(self)
        if self.scale == 0:
            raise ValueError("scale: expected a number other than 0, got 0")
        is_number = self.type in FORMATS
        if not is_number and (self.scale != 1 or self.offset != 0 or self.min is not None or self.max is not None):
            raise ValueError(f"scale, offset, min and max apply to numbers, not to {self.type}: remove them")
        if self.wire is not None and self.type.startswith("string"):
            raise ValueError("wire: expected no wire, because a wire cannot carry a text")
        if self.source is not None and self.type.startswith("string"):
            raise ValueError("source: expected a number or bool as the type, because a source has no texts")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError(f"min {self.min}: expected at most max, which is {self.max}")
        if self.factor_from is not None and self.exponent_from is not None:
            raise ValueError("exponent_from: expected either factor_from or exponent_from")
        self._check_parts()
        if self.initial is not None:
            _check_initial(self, number_of(self.values, self.initial))
        return self

    def _check_parts(self) -> None:
        """ValueError for names of numbers, and for bits, that the type does not have."""
        form = Form(self.type)
        is_scaled = self.scale != 1 or self.offset != 0 or self.is_scaled_by_another
        if self.is_scaled_by_another and not form.is_number:
            raise ValueError(f"factor_from and exponent_from apply to numbers, not to {self.type}: remove them")
        for key in ("values", "bits"):
            if getattr(self, key) and (form.is_float or not form.is_number or is_scaled):
                raise ValueError(f"{key}: expected an integer type without scale and offset")
        _check_names(self.values, form.low, form.high)
        if self.bits and not self.type.startswith("u"):
            raise ValueError(f"bits: expected u16, u32 or u64 as the type, got {self.type}")
        if self.bits and self.count > 1:
            raise ValueError("bits: expected a count of 1")
        if self.bits and (self.min is not None or self.max is not None):
            raise ValueError("min and max apply to numbers, not to bits: remove them")
        if self.source is not None and any(field.wire is not None for field in self.bits):
            raise ValueError("bits: expected no wires, because the value lives by itself")
        taken = 0
        for field in self.bits:
            if field.bit + field.width > 16 * self.words:
                raise ValueError(f"bits: expected that {field.name} ends at bit {16 * self.words - 1} or below")
            if field.mask & taken:
                raise ValueError(f"bits: expected bits for {field.name} that no other name has")
            taken |= field.mask

    @property
    def is_scaled_by_another(self) -> bool:
        """True if a register of the table takes part in the scale."""
        return self.factor_from is not None or self.exponent_from is not None


class Fifo(Settings):
    """A queue that function 24 reads; `address` is that of its pointer.  A wire or a point appends values.

    A full queue drops its oldest value.
    """

    address: Address
    name: Name
    depth: int = Field(
        default=31, ge=1, le=65535, description="size; reading more than 31 values is exception 03 (6.18)"
    )
    initial: list[Annotated[int, Field(ge=0, le=0xFFFF)]] = Field(default_factory=list)
    wire: str | None = Field(default=None, description="a signal whose value is appended when it changes")
    about: str = ""


class RecordFile(Settings):
    """A file whose records, each a register, functions 20 and 21 read and write."""

    number: int = Field(ge=1, le=0xFFFF, description="number of the file")
    name: Name
    records: int = Field(default=10_000, ge=1, le=10_000, description="number of records, from 0")
    initial: list[Annotated[int, Field(ge=0, le=0xFFFF)]] = Field(
        default_factory=list, description="contents of the first records"
    )
    access: Literal["ro", "rw"] = Field(default="rw", description="access of clients")
    about: str = ""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(self.initial) > self.records:
            raise ValueError(f"initial: expected at most {self.records} values, got {len(self.initial)}")
        return self


def words_of(entry: Bit | Register) -> int:
    """Number of addresses that one value occupies."""
    return entry.words if isinstance(entry, Register) else 1


def each_value(entry: Bit | Register) -> Iterator[tuple[str, int]]:
    """Yield the name and the address of each of the `count` values."""
    if entry.count == 1:
        yield entry.name, entry.address
        return
    for index in range(entry.count):
        yield f"{entry.name}.{index}", entry.address + index * words_of(entry)


def fields_of(entry: Bit | Register) -> Sequence[BitField]:
    """The named bits of a value."""
    return entry.bits if isinstance(entry, Register) else ()


def number_of(values: Mapping[int, str], value: Value) -> Value:
    """The number that a name stands for; any other value is returned as it is."""
    return next((number for number, name in values.items() if name == value), value)


def factor_in(value: Value, is_exponent: bool) -> float:
    """The factor that a register has.  An exponent beyond any power of ten, such as SunSpec's 8000h, counts as 0."""
    number = float(value)
    if not is_exponent:
        return number if math.isfinite(number) else 0
    return 10.0 ** round(number) if abs(number) <= MOST_EXPONENT else 1


def _check_names(values: Mapping[int, str], low: float, high: float) -> None:
    """ValueError for numbers outside the range of the value, and for names that two of them have."""
    for number, name in values.items():
        if not low <= number <= high:
            raise ValueError(f"values: expected numbers from {low} to {high}, got {number}")
        if not name or name.strip() != name:
            raise ValueError(f"values: expected a name for {number}, got {name!r}")
    if len(set(values.values())) < len(values):
        raise ValueError("values: expected each name once")


def _check_common(entry: Bit | Register) -> None:
    if entry.wire is None and entry.direction is not None:
        raise ValueError("direction: expected a wire beside it")
    if entry.wire is not None and entry.count > 1:
        raise ValueError("count: expected 1 for an entry with a wire; write one entry for each wire")
    if entry.source is not None:
        for key in ("wire", "initial", "retained"):
            if key in entry.model_fields_set:
                raise ValueError(f"{key} has no meaning beside source: remove one of the two")
        if entry.access == "wo":
            raise ValueError("access: expected ro or rw, because the value lives by itself")
    if entry.address + entry.count * words_of(entry) > 0x10000:
        raise ValueError("address: expected that all registers end at 65535 or below")


def _check_initial(register: Register, initial: Value) -> None:
    wanted: dict[str, tuple[type, ...]] = {"bool": (bool,)} | dict.fromkeys(FORMATS, (int, float))
    types = wanted.get(register.type, (str,))
    if not isinstance(initial, types) or (isinstance(initial, bool) and bool not in types):
        raise ValueError(f"initial: expected a value of type {register.type}, got {initial!r}")
    if isinstance(initial, str):
        if len(initial) > characters_in(register.type) or not initial.isascii():
            raise ValueError(f"initial: expected ASCII text that fits into {register.type}, got {initial!r}")
    elif register.type in FORMATS:
        if not register.is_scaled_by_another:
            check_size(register, initial)
        low, high = register.min, register.max
        if (low is not None and initial < low) or (high is not None and initial > high):
            raise ValueError(f"initial: expected a value from min to max, got {initial}")


def check_size(register: Register, initial: Number, factor: float = 1) -> None:
    """ValueError for a start value that does not fit; `factor` is that of another register.

    A value between two that an integer has is rounded, but one that would be lost in it is a mistake.
    """
    form, scale = Form(register.type), register.scale * factor
    raw = (initial - register.offset) / scale if scale else 0
    try:
        form.pack(raw if form.is_float else round(raw))
    except (struct.error, OverflowError) as cause:
        raise ValueError(_too_large(register, form, initial, raw, scale)) from cause
    if not form.is_float and raw and round(raw) == 0:
        raise ValueError(
            f"initial: {_in_register(register, initial, raw, scale)}, which is rounded to 0; expected"
            f" {register.offset:.12g}, or at least {abs(scale):.12g} away from it, in the unit of the value"
        )


def _in_register(register: Register, initial: Number, raw: float, scale: float) -> str:
    offset = f" and offset {register.offset:.12g}" if register.offset else ""
    return f"{initial:.12g} is {raw:.12g} in the register, by scale {scale:.12g}{offset}"


def _too_large(register: Register, form: Form, initial: Number, raw: float, scale: float) -> str:
    """Return what is wrong with a start value, and what scale and offset make of it."""
    ends = sorted(number * scale + register.offset for number in (form.low, form.high))
    expected = f"expected {ends[0]:.12g} to {ends[1]:.12g}, for {register.type}"
    if scale == 1 and register.offset == 0:
        return f"initial: {expected}, got {initial:.12g}"
    return f"initial: {_in_register(register, initial, raw, scale)}; {expected}, in the unit of the value"
