"""The registers and bits of one unit by address: names and values of what a message has, from its register table."""

from collections.abc import Iterator
from typing import Final, NamedTuple

from fieldrig.points.values import show_number
from fieldrig.traces.names import listed
from fieldrig.traces.parts import Part
from fieldrig_devices.registers.entries import Bit, Register, each_value, fields_of
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

    def addresses(self) -> dict[str, tuple[str, int, int]]:
        """Return space, first address and number of registers or bits of each value, by its name."""
        return {
            place.name: (space, address, place.entry.words if isinstance(place.entry, Register) else 1)
            for space, places in self._places.items()
            for address, place in places.items()
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

    def parts(self, space: str, address: int, data: bytes) -> list[Part]:
        """Return the values of registers whose bytes are `data`, one by one."""
        found = []
        for at, words in self._starts(space, address, len(data) // 2):
            raw = data[2 * (at - address) :][: 2 * words]
            found.append(Part(self._label(space, at), "", *self._number(space, at, raw), self._bits(space, at)))
        return found

    def _number(self, space: str, address: int, data: bytes) -> tuple[int | float | str, str]:
        """Return a value as it is compared, and in words."""
        place = self._places[space].get(address)
        text = self._value(space, address, data)
        entry = None if place is None else place.entry
        if not isinstance(entry, Register) or len(data) < 2 * entry.words:
            return int.from_bytes(data[:2]), text
        form = self._table.form_of(entry)
        if entry.type == "bool" or not form.is_number:
            return text, text
        number = form.unpack(data)
        if entry.bits:
            return number, f"{int(number):0{2 * len(data)}X}h"
        return number if entry.values or entry.is_scaled_by_another else number * entry.scale + entry.offset, text

    def _bits(self, space: str, address: int) -> dict[int, str]:
        place = self._places[space].get(address)
        fields = () if place is None else fields_of(place.entry)
        return {bit: field.name for field in fields for bit in range(field.bit, field.bit + field.width)}

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
