"""A Modbus register table in a YAML file: the address, type, unit, scale and wire of each value.

    word_order: big
    holding_registers:
      - {address: 0, name: speed_set, type: u16, unit: "%", scale: 0.1, max: 100, wire: pump.speed}
    input_registers:
      - {address: 0, name: level, type: u16, unit: m, scale: 0.001, wire: tank.level}

Addresses are as on the wire, from 0.  An address that no entry covers does not exist (exception 02).  A value is
`raw * scale + offset`, in `unit`, and so are `min`, `max` and `initial`.  An entry reads its wire in the spaces that
clients cannot write and where access is ro, and drives it elsewhere, unless `direction` is given.
"""

import struct
from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from fieldrig.config.settings_file import load_settings
from fieldrig.config.yaml_source import key_text
from fieldrig.settings import Settings, WrongKey
from fieldrig_devices.registers.form import FORMATS, TYPE_PATTERN, ByteOrder, Form, WordOrder, characters_in, words_in
from fieldrig_devices.registers.type_names import naming
from fieldrig_devices.sources.settings import SourceSettings

Value = bool | int | float | str
Number = int | float
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
    source: SourceSettings | None = Field(default=None, description="a value that lives by itself; clients read it")
    count: int = Field(default=1, ge=1, le=65536, description="number of identical entries, named name.0, name.1, ...")
    about: str = ""

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_common(self)
        return self


class Register(Settings):
    """One value in holding or input registers, or `count` of them starting at `address`."""

    address: Address
    name: Name
    type: Annotated[str, naming("bool", *FORMATS, "string[n]")] = Field(
        default="u16",
        pattern=TYPE_PATTERN,
        description="bool, u16, s16, u32, s32, u64, s64, f32, f64, or string[n] of n characters, two per register",
    )
    unit: str = ""
    access: Access | None = Field(
        default=None, description="access of clients; default rw for holding registers, ro for input registers"
    )
    scale: Number = 1
    offset: Number = 0
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
    source: SourceSettings | None = Field(default=None, description="a value that lives by itself; clients read it")
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
        if self.initial is not None:
            _check_initial(self, self.initial)
        return self


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


class Table(Settings):
    """The data of one unit."""

    about: str = ""
    word_order: WordOrder = "big"
    byte_order: ByteOrder = "big"
    coils: list[Bit] = Field(default_factory=list)
    discrete_inputs: list[Bit] = Field(default_factory=list)
    holding_registers: list[Register] = Field(default_factory=list)
    input_registers: list[Register] = Field(default_factory=list)
    fifos: list[Fifo] = Field(default_factory=list)

    def entries(self, space: str) -> Sequence[Bit | Register]:
        """The entries of one of `SPACES`."""
        spaces: dict[str, Sequence[Bit | Register]] = {
            "coils": self.coils,
            "discrete_inputs": self.discrete_inputs,
            "holding_registers": self.holding_registers,
            "input_registers": self.input_registers,
        }
        return spaces[space]

    def form_of(self, register: Register) -> Form:
        """The form of a register's value, in its own order or else that of the table."""
        return Form(register.type, register.word_order or self.word_order, register.byte_order or self.byte_order)


SPACES = ("coils", "discrete_inputs", "holding_registers", "input_registers")
WRITABLE_SPACES = ("coils", "holding_registers")


def access_of(space: str, entry: Bit | Register) -> Access:
    return entry.access or ("rw" if space in WRITABLE_SPACES and entry.source is None else "ro")


def direction_of(space: str, entry: Bit | Register) -> Direction:
    return entry.direction or ("from_wire" if access_of(space, entry) == "ro" else "to_wire")


def driven_wires(table: Table) -> Iterator[str]:
    """The wires that a unit with this table drives."""
    for space in WRITABLE_SPACES:
        for entry in table.entries(space):
            if entry.wire is not None and direction_of(space, entry) == "to_wire":
                yield entry.wire


def words_of(entry: Bit | Register) -> int:
    """Number of addresses that one value occupies."""
    return entry.words if isinstance(entry, Register) else 1


def load_table(path: Path, check: Callable[["Table"], Iterator[WrongKey]] = lambda table: iter(())) -> Table:
    """Load a register table from a file.  ConfigError with every mistake, also those that `check` yields."""
    return load_settings(path, Table, lambda table: chain(_conflicts(table), check(table)))


def _check_common(entry: Bit | Register) -> None:
    if entry.wire is None and entry.direction is not None:
        raise ValueError("direction: expected a wire beside it")
    if entry.wire is not None and entry.count > 1:
        raise ValueError("count: expected 1 for an entry with a wire; write one entry for each wire")
    if entry.source is not None:
        for key in ("wire", "initial", "retained"):
            if key in entry.model_fields_set:
                raise ValueError(f"{key} has no meaning beside source: remove one of the two")
        if entry.access not in (None, "ro"):
            raise ValueError("access: expected ro, because the value lives by itself")
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
        form = Form(register.type)
        raw = (initial - register.offset) / register.scale
        try:
            form.pack(raw if form.is_float else round(raw))
        except (struct.error, OverflowError) as cause:
            raise ValueError(_too_large(register, form, initial, raw)) from cause
        low, high = register.min, register.max
        if (low is not None and initial < low) or (high is not None and initial > high):
            raise ValueError(f"initial: expected a value from min to max, got {initial}")


def _too_large(register: Register, form: Form, initial: int | float, raw: float) -> str:
    """Return what is wrong with a start value, and what scale and offset make of it."""
    ends = sorted(number * register.scale + register.offset for number in (form.low, form.high))
    expected = f"expected {ends[0]:.12g} to {ends[1]:.12g}, for {register.type}"
    if register.scale == 1 and register.offset == 0:
        return f"initial: {expected}, got {initial:.12g}"
    offset = f" and offset {register.offset:.12g}" if register.offset else ""
    return (
        f"initial: {initial:.12g} is {raw:.12g} in the register, by scale {register.scale:.12g}{offset}; {expected},"
        " in the unit of the value"
    )


def _conflicts(table: Table) -> Iterator[WrongKey]:
    """Yield the mistakes between entries: names, addresses and wires that are used twice, and wrong directions."""
    names: dict[str, str] = {}
    drivers: dict[str, str] = {}
    for space in SPACES:
        entries = table.entries(space)
        yield from _overlaps(space, entries)
        for index, entry in enumerate(entries):
            here = (space, index)
            yield from _twice(names, entry.name, here, "name")
            if space not in WRITABLE_SPACES and (entry.access or "ro") != "ro":
                yield WrongKey((*here, "access"), f"a client cannot write {space.replace('_', ' ')}", "expected ro")
            elif entry.wire is not None and direction_of(space, entry) == "to_wire":
                if access_of(space, entry) == "ro":
                    what = "no client can write it, so it cannot drive a wire"
                    yield WrongKey((*here, "direction"), what, "expected from_wire")
                yield from _twice(drivers, entry.wire, here, "wire")
    fifos: dict[int, str] = {}
    for index, fifo in enumerate(table.fifos):
        yield from _twice(names, fifo.name, ("fifos", index), "name")
        yield from _twice(fifos, fifo.address, ("fifos", index), "address")


def _overlaps(space: str, entries: Sequence[Bit | Register]) -> Iterator[WrongKey]:
    last_end, last = 0, ""
    for address, index in sorted((entry.address, index) for index, entry in enumerate(entries)):
        entry = entries[index]
        if address < last_end:
            what = f"address {address} is in use by {last}"
            yield WrongKey((space, index, "address"), what, f"addresses from {last_end} on are free")
        end = address + entry.count * words_of(entry)
        if end > last_end:
            last_end, last = end, entry.name


def _twice(known: dict[Any, str], used: Any, here: tuple[Any, ...], key: str) -> Iterator[WrongKey]:
    if used in known:
        yield WrongKey((*here, key), f"{used} is already used at {known[used]}", f"use each {key} once")
    known.setdefault(used, key_text(here))
