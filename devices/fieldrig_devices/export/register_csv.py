"""A register table as a CSV list, in the columns that `fieldrig new --registers` reads back.

The list has what a list of a maker has.  Queues, files, wires and sources are not in it, and names of numbers and bits
are in the remarks, where a person reads them.
"""

import csv
import io
from collections.abc import Iterator, Sequence
from typing import Final

from fieldrig_devices.begin.register_list import OWN_COLUMNS
from fieldrig_devices.registers.entries import Bit, Register, each_value, fields_of, number_of
from fieldrig_devices.registers.table import SPACES, Table, access_of

ORDERS: Final = {("big", "big"): "", ("little", "big"): "cdab", ("big", "little"): "badc", ("little", "little"): "dcba"}
"""The order of the bytes ABCD of a number, by the orders of words and bytes."""
LOOKS_NUMBERED: Final = range(10_000, 50_000)
"""Addresses that a reader could take for numbers such as 40001."""


def csv_of(table: Table) -> str:
    """Return the list."""
    file = io.StringIO(newline="")
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(OWN_COLUMNS)
    writer.writerows(rows_of(table))
    return file.getvalue()


def rows_of(table: Table) -> Iterator[Sequence[object]]:
    """Yield a row of `OWN_COLUMNS` for each entry, and for each single one of several bits."""
    exponents = {entry.exponent_from for entry in (*table.holding_registers, *table.input_registers)}
    for space in SPACES:
        for entry in table.entries(space):
            for name, address in [(entry.name, entry.address)] if isinstance(entry, Register) else each_value(entry):
                yield _row(table, space, entry, name, address, entry.name in exponents)


def _row(
    table: Table, space: str, entry: Bit | Register, name: str, address: int, is_exponent: bool
) -> Sequence[object]:
    access, place = access_of(space, entry), hex(address) if address in LOOKS_NUMBERED else address
    word = space.removesuffix("s").replace("_", " ")
    if not isinstance(entry, Register):
        return (place, name, "bool", word, "", "", "", access, "", "", int(entry.initial), about_of(entry))
    by = entry.factor_from or entry.exponent_from or ""
    scale = f"{entry.scale} x {by}" if by and entry.scale != 1 else by or _plain(entry.scale, 1)
    type = _type(table, entry, is_exponent)
    limits = (_plain(entry.min, None), _plain(entry.max, None), _initial(entry))
    return (place, name, type, word, entry.unit, scale, _plain(entry.offset, 0), access, *limits, about_of(entry))


def _type(table: Table, entry: Register, is_exponent: bool) -> str:
    """Return the type with the number of values, and with the order of its bytes where that is not ABCD."""
    type = "sunssf" if is_exponent and entry.type == "s16" else entry.type
    form = (entry.word_order or table.word_order, entry.byte_order or table.byte_order)
    order = ORDERS[form] if entry.type != "bool" else ""
    count = f"[{entry.count}]" if entry.count > 1 and not entry.type.startswith("string") else ""
    return f"{type}{count} {order}".strip()


def _initial(entry: Register) -> object:
    if entry.initial is None or isinstance(entry.initial, bool):
        return "" if entry.initial is None else int(entry.initial)
    return number_of(entry.values, entry.initial)


def _plain(number: float | None, usual: float | None) -> object:
    return "" if number is None or number == usual else number


def about_of(entry: Bit | Register) -> str:
    """Return the remarks: what the entry is, and the names of its numbers and bits."""
    parts = [entry.about]
    if isinstance(entry, Register):
        parts.append(", ".join(f"{number} = {name}" for number, name in entry.values.items()))
    for bits in fields_of(entry):
        place = f"bit {bits.bit}" if bits.width == 1 else f"bits {bits.bit} to {bits.bit + bits.width - 1}"
        names = ", ".join(f"{number} = {name}" for number, name in bits.values.items())
        parts.append(f"{place}: {bits.name}{f' ({names})' if names else ''}")
    return "; ".join(filter(None, parts))
