"""The registers and bits of one unit by address: names and values of what a message has, from its register table."""

from collections.abc import Iterator
from typing import Final, NamedTuple

from fieldrig.points.values import show_number
from fieldrig.traces.names import listed
from fieldrig_devices.registers.entries import Bit, Register, each_value
from fieldrig_devices.registers.table import SPACES, Table

MOST_ADDRESSES: Final = 2_000
"""The most bits that one message can have (V1.1b3, 6.1); a wrong request can ask for more."""


class _Place(NamedTuple):
    name: str
    entry: Bit | Register


class NamedRegisters:
    """The table of one unit, by space and address."""

    def __init__(self, table: Table) -> None:
        self._table = table
        self._places = {
            space: {
                address: _Place(name, entry) for entry in table.entries(space) for name, address in each_value(entry)
            }
            for space in SPACES
        }

    def names(self, space: str, address: int, count: int) -> str:
        """Return the names of `count` registers or bits from `address` on."""
        return listed(self._label(space, at) for at, _ in self._starts(space, address, count))

    def registers(self, space: str, address: int, data: bytes) -> str:
        """Return names and values of registers whose bytes are `data`."""
        starts = self._starts(space, address, len(data) // 2)
        return listed(
            f"{self._label(space, at)} {self._value(space, at, data[2 * (at - address) :])}" for at, _ in starts
        )

    def bits(self, space: str, address: int, count: int, data: bytes) -> str:
        """Return names and values of `count` bits, the lowest one of the first byte first."""
        number = int.from_bytes(data, "little")
        return listed(
            f"{self._label(space, at)} {'on' if number >> at - address & 1 else 'off'}"
            for at in range(address, address + min(count, 8 * len(data)))
        )

    def _starts(self, space: str, address: int, count: int) -> Iterator[tuple[int, int]]:
        """Yield the addresses at which values begin, with their sizes; a register inside a value stands for itself."""
        at, end = address, address + min(count, MOST_ADDRESSES)
        while at < end:
            place = self._places[space].get(at)
            words = place.entry.words if place is not None and isinstance(place.entry, Register) else 1
            yield at, words
            at += words

    def _label(self, space: str, address: int) -> str:
        place = self._places[space].get(address)
        return str(address) if place is None else place.name

    def _value(self, space: str, address: int, data: bytes) -> str:
        place = self._places[space].get(address)
        entry = None if place is None else place.entry
        if not isinstance(entry, Register) or len(data) < 2 * entry.words:
            return data[:2].hex().upper() + "h"
        return _value_of(self._table, entry, data[: 2 * entry.words])


def _value_of(table: Table, entry: Register, data: bytes) -> str:
    form = table.form_of(entry)
    if entry.type == "bool":
        return "on" if any(data) else "off"
    if not form.is_number:
        return repr(form.unpack_text(data))
    number = form.unpack(data)
    if entry.is_scaled_by_another:  # the factor is in another register, which this message need not have
        return f"{show_number(number)} raw"
    if number in entry.values:
        return entry.values[int(number)]
    value = float(f"{number * entry.scale + entry.offset:.12g}")
    return f"{show_number(value)} {entry.unit}".rstrip()
