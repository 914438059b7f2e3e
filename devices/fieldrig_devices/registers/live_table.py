"""A register table over the points of a device: each entry shows the point of its name, and a client's write sets it.

A value is `raw * scale + offset`, as in any register table.  A point that refuses a value refuses the request.  Wires,
queues, counts and non-volatile values belong to devices that have nothing but a table, so they are refused here.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from fieldrig.device import Point, Value
from fieldrig.settings import WrongKey
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, SERVER_DEVICE_FAILURE, ModbusError
from fieldrig_devices.registers.entries import Bit, Register
from fieldrig_devices.registers.form import FLOATS
from fieldrig_devices.registers.live import BitEntry, Entry, LiveBits, LiveRegisters
from fieldrig_devices.registers.table import SPACES, Table, access_of

Lookup = Callable[[str], Point | None]
"""Returns the point of a name, or None if there is none."""
_FOREIGN: Mapping[str, Any] = {
    "wire": None,
    "retained": False,
    "count": 1,
    "initial": None,
    "word_order": None,
    "byte_order": None,
    "source": None,
    "factor_from": None,
    "exponent_from": None,
    "bits": [],
    "values": {},
}
"""Keys of an entry that have no meaning here, and their defaults."""


class LiveUnit(NamedTuple):
    """Implements `DataModel` of fieldrig_bus.modbus.server."""

    coils: LiveBits
    discrete_inputs: LiveBits
    holding_registers: LiveRegisters
    input_registers: LiveRegisters

    def fifo(self, address: int) -> list[int]:
        raise ModbusError(ILLEGAL_DATA_ADDRESS)

    def exception_status(self) -> int:
        return 0


def wrong_entries(table: Table, find: Lookup) -> Iterator[WrongKey]:
    """Yield the entries that have no point, and the keys that have no meaning here."""
    for key, what in (("fifos", "queues"), ("files", "files")):
        if getattr(table, key):
            yield WrongKey((key,), f"this device has no {what}", "remove them")
    for space in SPACES:
        for index, entry in enumerate(table.entries(space)):
            here = (space, index)
            for key, default in _FOREIGN.items():
                if getattr(entry, key, default) not in (default, False, None):
                    yield WrongKey((*here, key), f"{key} has no meaning here", "an entry shows the point of its name")
            point = find(entry.name)
            if point is None:
                yield WrongKey((*here, "name"), f"there is no {entry.name}", "expected a point of the device")
            elif point.write is None and access_of(space, entry) != "ro":
                yield WrongKey((*here, "access"), f"no client can write {entry.name}", "expected ro")


def live_unit(table: Table, find: Lookup, refusal: int = SERVER_DEVICE_FAILURE) -> LiveUnit:
    """Connect a table without `wrong_entries` to its points."""
    bits = {space: LiveBits([_bit(space, bit, find) for bit in table.entries(space)]) for space in SPACES[:2]}
    registers = {
        space: LiveRegisters(
            [_register(space, entry, find, refusal) for entry in table.entries(space)],
            table.word_order,
            refusal,
            table.byte_order,
        )
        for space in SPACES[2:]
    }
    return LiveUnit(
        bits["coils"], bits["discrete_inputs"], registers["holding_registers"], registers["input_registers"]
    )


def _bit(space: str, bit: Bit | Register, find: Lookup) -> BitEntry:
    point = _found(bit, find)
    write = None if access_of(space, bit) == "ro" else _writer(point, SERVER_DEVICE_FAILURE)
    return BitEntry(bit.address, bit.name, lambda: bool(point.read()), write)


def _register(space: str, entry: Bit | Register, find: Lookup, refusal: int) -> Entry:
    assert isinstance(entry, Register), "registers have no bits"
    point, register = _found(entry, find), entry
    is_scaled, is_real = register.scale != 1 or register.offset != 0, register.type in FLOATS
    act = None if access_of(space, entry) == "ro" else _writer(point, refusal)

    def read() -> Value:
        value = point.read()
        if isinstance(value, str) or not is_scaled:
            return value
        raw = (value - register.offset) / register.scale
        return raw if is_real else round(raw)

    def write(value: Value) -> None:
        assert act is not None, "the entry is writable"
        act(_shown(register, value))

    def check(value: Value) -> None:
        shown = _shown(register, value)
        low, high = register.min, register.max
        if isinstance(shown, str):
            return
        if (low is not None and shown < low) or (high is not None and shown > high):
            raise ValueError(f"{register.name}: expected {low} to {high}, got {shown}")

    return Entry(
        register.address,
        register.name,
        register.type,
        read,
        None if act is None else write,
        check,
        register.unit or point.unit,
        register.about or point.about,
    )


def _shown(register: Register, raw: Value) -> Value:
    """The value of the point for a raw value; twelve digits, so that 3 * 0.1 equals a limit of 0.3 in the table."""
    if isinstance(raw, str) or (register.scale == 1 and register.offset == 0):
        return raw
    return float(f"{raw * register.scale + register.offset:.12g}")


def _found(entry: Bit | Register, find: Lookup) -> Point:
    point = find(entry.name)
    assert point is not None, "`wrong_entries` has found each point"
    return point


def _writer(point: Point, refusal: int) -> Callable[[Value], None]:
    write = point.write
    assert write is not None, "`wrong_entries` has compared access and point"

    def act(value: Value) -> None:
        try:
            write(value)
        except ValueError as cause:
            raise ModbusError(refusal) from cause

    return act
