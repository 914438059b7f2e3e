"""A Modbus register table in a YAML file: what has which address, type, unit and scale, and which wire it is tied to.

    word_order: big
    holding_registers:
      - {address: 0, name: speed_set, type: u16, unit: "%", scale: 0.1, max: 100, wire: pump.speed}
    input_registers:
      - {address: 0, name: level, type: u16, unit: m, scale: 0.001, wire: tank.level}

Addresses are as on the wire, from 0.  What no entry covers is not there (exception 02).  A value is `raw * scale +
offset`, in `unit`, and so are `min`, `max` and `initial`.  A wire is read or driven: read in the spaces that a client
can't write and where access is ro, driven elsewhere; `direction` says otherwise.
"""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, StringConstraints, model_validator

from fieldrig.settings import Settings, WrongKey
from fieldrig.settings_file import load_settings
from fieldrig.yaml_source import key_text

Value = bool | int | float | str
Number = int | float
Access = Literal["ro", "rw", "wo"]
Direction = Literal["from_wire", "to_wire"]
WordOrder = Literal["big", "little"]
Address = Annotated[int, Field(ge=0, le=0xFFFF)]
Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_.-]*$")]

FORMATS = {"u16": "H", "s16": "h", "u32": "I", "s32": "i", "f32": "f", "u64": "Q", "s64": "q", "f64": "d"}
WORDS = {name: struct.calcsize(f">{code}") // 2 for name, code in FORMATS.items()} | {"bool": 1}
FLOATS = frozenset({"f32", "f64"})
TYPE_PATTERN = r"^(bool|[usf]32|[usf]64|[us]16|string\[([1-9][0-9]?|1[0-9][0-9]|2[0-4][0-9]|250)\])$"


class Bit(Settings):
    """One coil or discrete input, or `count` of them from `address` on."""

    address: Address
    name: Name
    initial: bool = False
    access: Access | None = Field(default=None, description="of clients; default rw for coils, ro for discrete inputs")
    wire: str | None = Field(default=None, description="a digital signal")
    direction: Direction | None = None
    retained: bool = Field(default=False, description="kept over power-off")
    count: int = Field(default=1, ge=1, le=65536, description="so many alike, named name.0, name.1, ...")
    about: str = ""

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_common(self)
        return self


class Register(Settings):
    """One value in holding or input registers, or `count` of them from `address` on."""

    address: Address
    name: Name
    type: str = Field(
        default="u16",
        pattern=TYPE_PATTERN,
        description="bool, u16, s16, u32, s32, u64, s64, f32, f64, or string[n] of n characters, two to a register",
    )
    unit: str = ""
    access: Access | None = Field(
        default=None, description="of clients; default rw for holding registers, ro for input registers"
    )
    scale: Number = 1
    offset: Number = 0
    initial: Value | None = None
    min: Number | None = None
    max: Number | None = None
    word_order: WordOrder | None = Field(default=None, description="big: the high word first; default as of the table")
    wire: str | None = Field(default=None, description="a signal in the same unit")
    direction: Direction | None = None
    retained: bool = Field(default=False, description="kept over power-off")
    count: int = Field(default=1, ge=1, le=65536, description="so many alike, named name.0, name.1, ...")
    about: str = ""

    @property
    def words(self) -> int:
        """Registers of one value."""
        return WORDS[self.type] if self.type in WORDS else (int(self.type[7:-1]) + 1) // 2

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_common(self)
        if self.scale == 0:
            raise ValueError("a scale of 0 makes every value the same: leave it out")
        is_number = self.type in FORMATS
        if not is_number and (self.scale != 1 or self.offset != 0 or self.min is not None or self.max is not None):
            raise ValueError(f"scale, offset, min and max are for numbers, not for {self.type}")
        if self.wire is not None and self.type.startswith("string"):
            raise ValueError("a wire carries no text")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError(f"min {self.min} is above max {self.max}")
        if self.initial is not None:
            _check_initial(self, self.initial)
        return self


class Fifo(Settings):
    """A queue that function 24 reads; `address` is its pointer's.  A wire, or a point, puts values in.

    When it is full the oldest goes.
    """

    address: Address
    name: Name
    depth: int = Field(default=31, ge=1, le=65535, description="more than 31 in the queue is exception 03 (6.18)")
    initial: list[Annotated[int, Field(ge=0, le=0xFFFF)]] = Field(default_factory=list)
    wire: str | None = Field(default=None, description="a number that is put into the queue when it changes")
    about: str = ""


class Table(Settings):
    """What one unit has."""

    about: str = ""
    word_order: WordOrder = "big"
    coils: list[Bit] = Field(default_factory=list)
    discrete_inputs: list[Bit] = Field(default_factory=list)
    holding_registers: list[Register] = Field(default_factory=list)
    input_registers: list[Register] = Field(default_factory=list)
    fifos: list[Fifo] = Field(default_factory=list)


SPACES = ("coils", "discrete_inputs", "holding_registers", "input_registers")
WRITABLE_SPACES = ("coils", "holding_registers")


def access_of(space: str, entry: Bit | Register) -> Access:
    return entry.access or ("rw" if space in WRITABLE_SPACES else "ro")


def direction_of(space: str, entry: Bit | Register) -> Direction:
    return entry.direction or ("from_wire" if access_of(space, entry) == "ro" else "to_wire")


def driven_wires(table: Table) -> Iterator[str]:
    for space in WRITABLE_SPACES:
        for entry in getattr(table, space):
            if entry.wire is not None and direction_of(space, entry) == "to_wire":
                yield entry.wire


def words_of(entry: Bit | Register) -> int:
    return entry.words if isinstance(entry, Register) else 1


def load_table(path: Path) -> Table:
    """Return the table that a file holds.  ConfigError with every mistake in the file."""
    return load_settings(path, Table, _conflicts)


def _check_common(entry: Bit | Register) -> None:
    if entry.wire is None and entry.direction is not None:
        raise ValueError("direction is the wire's: name a wire too")
    if entry.wire is not None and entry.count > 1:
        raise ValueError("one wire is tied to one value: give each its own entry instead of count")
    if entry.address + entry.count * words_of(entry) > 0x10000:
        raise ValueError("it goes beyond address 65535")


def _check_initial(register: Register, initial: Value) -> None:
    wanted: dict[str, tuple[type, ...]] = {"bool": (bool,)} | dict.fromkeys(FORMATS, (int, float))
    types = wanted.get(register.type, (str,))
    if not isinstance(initial, types) or (isinstance(initial, bool) and bool not in types):
        raise ValueError(f"initial {initial!r} is no {register.type}")
    if isinstance(initial, str):
        if len(initial) > int(register.type[7:-1]) or not initial.isascii():
            raise ValueError(f"initial {initial!r} doesn't fit into {register.type} (ASCII)")
    elif register.type in FORMATS:
        raw = (initial - register.offset) / register.scale
        try:
            struct.pack(f">{FORMATS[register.type]}", raw if register.type in FLOATS else round(raw))
        except (struct.error, OverflowError) as cause:
            raise ValueError(f"initial {initial} doesn't fit into {register.type}") from cause
        low, high = register.min, register.max
        if (low is not None and initial < low) or (high is not None and initial > high):
            raise ValueError(f"initial {initial} is not between min and max")


def _conflicts(table: Table) -> Iterator[WrongKey]:
    """Yield what is wrong in entries that are right one by one: names or addresses used twice, directions."""
    names: dict[str, str] = {}
    drivers: dict[str, str] = {}
    for space in SPACES:
        entries: list[Bit | Register] = getattr(table, space)
        yield from _overlaps(space, entries)
        for index, entry in enumerate(entries):
            here = (space, index)
            yield from _twice(names, entry.name, here, "name")
            if space not in WRITABLE_SPACES and (entry.access or "ro") != "ro":
                yield WrongKey((*here, "access"), f"a client can't write {space.replace('_', ' ')}", "expected ro")
            elif entry.wire is not None and direction_of(space, entry) == "to_wire":
                if access_of(space, entry) == "ro":
                    what = "no client can write it, so it can't drive a wire"
                    yield WrongKey((*here, "direction"), what, "expected from_wire")
                yield from _twice(drivers, entry.wire, here, "wire")
    fifos: dict[int, str] = {}
    for index, fifo in enumerate(table.fifos):
        yield from _twice(names, fifo.name, ("fifos", index), "name")
        yield from _twice(fifos, fifo.address, ("fifos", index), "address")


def _overlaps(space: str, entries: list[Bit | Register]) -> Iterator[WrongKey]:
    last_end, last = 0, ""
    for address, index in sorted((entry.address, index) for index, entry in enumerate(entries)):
        entry = entries[index]
        if address < last_end:
            what = f"address {address} is in use by {last}"
            yield WrongKey((space, index, "address"), what, f"addresses from {last_end} on are free")
        end = address + entry.count * words_of(entry)
        if end > last_end:
            last_end, last = end, entry.name


def _twice(known: dict[Any, str], what: Any, here: tuple[Any, ...], key: str) -> Iterator[WrongKey]:
    if what in known:
        yield WrongKey((*here, key), f"{what} is already used at {known[what]}", f"use each {key} once")
    known.setdefault(what, key_text(here))
