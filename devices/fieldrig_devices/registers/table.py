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

from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from pydantic import Field

from fieldrig.config.settings_file import load_settings
from fieldrig.config.yaml_source import key_text
from fieldrig.settings import Settings, WrongKey
from fieldrig.text.nearest import closest
from fieldrig_devices.registers.entries import (
    Access,
    Bit,
    BitField,
    Direction,
    Fifo,
    Number,
    RecordFile,
    Register,
    check_size,
    each_value,
    factor_in,
    fields_of,
    number_of,
    words_of,
)
from fieldrig_devices.registers.form import FORMATS, ByteOrder, Form, WordOrder


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
    files: list[RecordFile] = Field(default_factory=list)

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


def direction_of(space: str, entry: Bit | Register, field: BitField | None = None) -> Direction:
    """The direction of a value at its wire, or that of a field in it."""
    given = entry.direction if field is None else field.direction
    return given or ("from_wire" if access_of(space, entry) == "ro" else "to_wire")


def driven_wires(table: Table) -> Iterator[str]:
    """The wires that a unit with this table drives."""
    for space in WRITABLE_SPACES:
        for entry in table.entries(space):
            if entry.wire is not None and direction_of(space, entry) == "to_wire":
                yield entry.wire
    for space in SPACES:
        for entry in table.entries(space):
            for field in fields_of(entry):
                if field.wire is not None and direction_of(space, entry, field) == "to_wire":
                    yield field.wire


def load_table(path: Path, check: Callable[["Table"], Iterator[WrongKey]] = lambda table: iter(())) -> Table:
    """Load a register table from a file.  ConfigError with every mistake, also those that `check` yields."""
    return load_settings(path, Table, lambda table: chain(_conflicts(table), check(table)))


def _conflicts(table: Table) -> Iterator[WrongKey]:
    """Yield the mistakes between entries: names, addresses and wires that are used twice, and wrong directions."""
    names: dict[str, str] = {}
    drivers: dict[str, str] = {}
    for space in SPACES:
        entries = table.entries(space)
        yield from _overlaps(space, entries)
        for index, entry in enumerate(entries):
            here = (space, index)
            yield from _taken_names(names, entry, here)
            if space not in WRITABLE_SPACES and (entry.access or "ro") != "ro":
                yield WrongKey((*here, "access"), f"a client cannot write {space.replace('_', ' ')}", "expected ro")
            elif entry.wire is not None and direction_of(space, entry) == "to_wire":
                if access_of(space, entry) == "ro":
                    what = "no client can write it, so it cannot drive a wire"
                    yield WrongKey((*here, "direction"), what, "expected from_wire")
                yield from _twice(drivers, entry.wire, here, "wire")
            yield from _wrong_fields(space, entry, here, names, drivers)
    yield from _wrong_scales(table)
    fifos: dict[int, str] = {}
    for index, fifo in enumerate(table.fifos):
        yield from _twice(names, fifo.name, ("fifos", index), "name")
        yield from _twice(fifos, fifo.address, ("fifos", index), "address")
    numbers: dict[str, str] = {}
    for index, file in enumerate(table.files):
        yield from _twice(names, file.name, ("files", index), "name")
        yield from _twice(numbers, file.number, ("files", index), "number")


def _wrong_fields(
    space: str, entry: Bit | Register, here: tuple[Any, ...], names: dict[str, str], drivers: dict[str, str]
) -> Iterator[WrongKey]:
    """Yield the mistakes of the named bits of a value."""
    for place, field in enumerate(fields_of(entry)):
        inner = (*here, "bits", place)
        yield from _twice(names, f"{entry.name}.{field.name}", inner, "name")
        if field.wire is not None and direction_of(space, entry, field) == "to_wire":
            yield from _twice(drivers, field.wire, inner, "wire")


def _wrong_scales(table: Table) -> Iterator[WrongKey]:
    """Yield the entries whose scale depends on a register that is not there, or that depends on another one itself."""
    scalable = {
        entry.name: entry
        for space in SPACES[2:]
        for entry in table.entries(space)
        if isinstance(entry, Register) and entry.count == 1 and entry.type in FORMATS
    }
    for space in SPACES[2:]:
        for index, entry in enumerate(table.entries(space)):
            assert isinstance(entry, Register), "the last two spaces are registers"
            for key in ("factor_from", "exponent_from"):
                name = getattr(entry, key)
                if name is None:
                    continue
                other = scalable.get(name)
                if other is None:
                    known = [known for known in scalable if known != entry.name]
                    yield WrongKey((space, index, key), f"there is no number {name}", closest(name, known))
                elif other.is_scaled_by_another:
                    yield WrongKey((space, index, key), f"{name} has no fixed scale itself", "name another register")
                elif isinstance(entry.initial, int | float):
                    yield from _wrong_initial((space, index), entry, entry.initial, other, key == "exponent_from")


def _wrong_initial(
    here: tuple[Any, ...], entry: Register, initial: Number, other: Register, is_exponent: bool
) -> Iterator[WrongKey]:
    """Yield the mistake of a start value that does not fit with the factor that another register starts with."""
    factor = factor_in(number_of(other.values, other.initial or 0), is_exponent)
    try:
        check_size(entry, initial, factor)
    except ValueError as cause:
        yield WrongKey((*here, "initial"), str(cause))


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


def _taken_names(names: dict[str, str], entry: Bit | Register, here: tuple[Any, ...]) -> Iterator[WrongKey]:
    """Yield the first name of an entry that another one has too, such as `tank.1` beside a `tank` with a count."""
    own = dict.fromkeys((entry.name, *(name for name, _ in each_value(entry))), key_text(here))
    taken = next((name for name in own if name in names), None)
    if taken is not None:
        yield from _twice(names, taken, here, "name")
    names |= {name: place for name, place in own.items() if name not in names}


def _twice(known: dict[Any, str], used: Any, here: tuple[Any, ...], key: str) -> Iterator[WrongKey]:
    if used in known:
        yield WrongKey((*here, key), f"{used} is already used at {known[used]}", f"use each {key} once")
    known.setdefault(used, key_text(here))
