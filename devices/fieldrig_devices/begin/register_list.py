"""A list of registers in a CSV file, as makers of field devices publish them, as a register table.

Lists differ, so columns are known by the words that people use for them, in any order.  What a list leaves open is
assumed, and what cannot be read is left out; the notes say both, with the lines.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from fieldrig.text.flow import flow
from fieldrig_devices.begin.list_columns import (
    BITS_OF_A_REGISTER,
    NUMBERED,
    address_in,
    bit_in,
    columns_of,
    is_in_hex,
    is_numbered_list,
    list_in,
    without_accents,
)
from fieldrig_devices.begin.list_orders import ORDERS, is_unsure, order_of
from fieldrig_devices.begin.list_scales import NOTHING, PRODUCT, factor, name_registers
from fieldrig_devices.begin.list_types import type_of
from fieldrig_devices.begin.list_values import values_in
from fieldrig_devices.begin.list_words import access_of, space_of
from fieldrig_devices.registers.entries import Bit, Register, words_of
from fieldrig_devices.registers.table import SPACES
from fieldrig_devices.sources.sheet import Sheet, text_of

FAMILIES: Final = {"0": "coils", "1": "discrete_inputs", "3": "input_registers", "4": "holding_registers"}
"""The first digit of numbers such as 40001, which name the space and count from 1."""
OWN_COLUMNS: Final = (
    "address", "name", "type", "space", "unit", "scale", "offset", "access", "min", "max", "initial", "about",
)  # fmt: skip
"""The first line of a list that `fieldrig export` has written; its names are those of a register table as they are."""
TYPES_BY_WORDS: Final = {1: "u16", 2: "u32", 4: "u64"}
MOST_SHOWN: Final = 3
"""Texts of a column that a note shows."""
ONES: Final = ("initial", "min", "max")
UMLAUTS: Final = {"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss", "ø": "o", "æ": "ae"}


@dataclass
class RegisterList:
    """The entries of a list by their spaces, and the notes for its reader."""

    entries: dict[str, list[dict[str, Any]]] = field(default_factory=lambda: {space: [] for space in SPACES})
    notes: list[str] = field(default_factory=list)

    def text(self, source: str) -> str:
        """Return the list as a register table."""
        lines = [f"# Made from {source}. Addresses are as on the wire, from 0."]
        lines += [f"# {note}" for note in self.notes]
        for space in SPACES:
            if self.entries[space]:
                lines += ["", f"{space}:", *(f"  - {flow(entry)}" for entry in self.entries[space])]
        return "\n".join(lines) + "\n"


def read_list(file: Path) -> RegisterList:
    """Read a list.  ValueError if there is no column of addresses, or no row that can be read."""
    sheet = list_in(text_of(file.read_bytes()))
    columns = columns_of(sheet.names)
    made = RegisterList()
    rows = list(_rows(sheet, columns))
    cells = [row["address"] for _, row in rows]
    is_hex = is_in_hex(sheet.names[columns["address"]], cells)
    is_numbered = not is_hex and is_numbered_list([(row["address"], _is_bit(row)) for _, row in rows])
    if is_hex:
        made.notes.append("Addresses were taken as hexadecimal numbers.")
    if is_numbered:
        made.notes.append("Addresses such as 40001 were taken as numbers that count from 1.")
    reader = _Reader(sheet, made, is_numbered=is_numbered, is_hex=is_hex)
    for line, row in rows:
        reader.take(line, row)
    reader.finish()
    made.notes += _unread(sheet, columns)
    if not any(made.entries.values()):
        raise ValueError("\n".join(["no row is a register", *made.notes]))
    for entries in made.entries.values():
        entries.sort(key=lambda entry: entry["address"])
    return made


class _Reader:
    """Makes an entry of each row."""

    def __init__(self, sheet: Sheet, made: RegisterList, *, is_numbered: bool, is_hex: bool) -> None:
        self._sheet, self._is_numbered, self._is_hex, self._made = sheet, is_numbered, is_hex, made
        self._as_name: Callable[[str], str] = str if tuple(sheet.names) == OWN_COLUMNS else _as_name
        self._names: set[str] = set()
        self._taken: dict[str, dict[int, str]] = {space: {} for space in SPACES}
        self._lines: dict[str, int] = {}
        self._scaled_by: dict[str, str] = {}
        """The text of a factor that is no number, as a name, by the name of the register."""
        self._exponents: set[str] = set()
        self._unnamed: dict[str, None] = {}
        """The texts in the column of values that name none."""

    def take(self, line: int, row: Mapping[str, str]) -> None:
        bit = _bit(row)
        try:
            if bit is not None:
                self._take_bit(row, bit)
                return
            if _is_wrong_bit(row):
                raise ValueError(f"{row['bit']!r} is no bit from 0 to {BITS_OF_A_REGISTER - 1}")
            space, entry = self._entry(row)
            words = self._words_of(space, entry)
            addresses = range(entry["address"], entry["address"] + words * entry.get("count", 1))
            taken = self._taken[space]
            other = next((taken[address] for address in addresses if address in taken), None)
            if other is not None:
                raise ValueError(f"its address is in use by {other}")
        except ValidationError as cause:
            self._leave_out(line, cause.errors()[0]["msg"].removeprefix("Value error, "))
        except ValueError as cause:
            self._leave_out(line, str(cause))
        else:
            self._assume(line, row, space, entry, words)
            taken |= dict.fromkeys(addresses, entry["name"])
            self._made.entries[space].append(entry)

    def _take_bit(self, row: Mapping[str, str], bit: int) -> None:
        """Add a bit to the register at its address.  ValueError if that is something else."""
        space, address = self._place(row)
        there = self._made.entries[space]
        owner = next((entry for entry in there if entry["address"] == address), None)
        if owner is None and address not in self._taken[space]:
            made = f"{space.removesuffix('s')}_{address}"
            made = f"{made}_bits" if made in self._names else made
            owner = {"address": address, "name": made, "type": "u16", "bits": []}
        name = self._as_name(row.get("name") or row.get("about") or "") or f"bit_{bit}"
        name = name if not name[0].isdigit() else f"r_{name}"
        there_already = [] if owner is None else owner.get("bits", [])
        name = f"{name}_{bit}" if any(entry["name"] == name for entry in there_already) else name
        bits = [*there_already, {"bit": bit, "name": name}]
        if owner is None or len({entry["bit"] for entry in bits}) < len(bits):
            raise ValueError(f"its address is in use by {self._taken[space][address]}")
        Register.model_validate(owner | {"bits": bits})
        if owner not in there:
            there.append(owner)
            self._names.add(owner["name"])
            self._taken[space][address] = owner["name"]
        owner["bits"] = bits

    def _words_of(self, space: str, entry: dict[str, Any]) -> int:
        """Return the registers that an entry needs, after removing the names of numbers that its type does not have."""
        model = Bit if space in SPACES[:2] else Register
        try:
            return words_of(model.model_validate(entry))
        except ValidationError:
            names = entry.pop("values", None)
            if names is None:
                raise
            self._unnamed[", ".join(f"{number} = {name}" for number, name in names.items())] = None
            return words_of(model.model_validate(entry))

    def finish(self) -> None:
        """Resolve the factors that are names of other registers, which may come later in the list."""
        registers = [entry for space in SPACES[2:] for entry in self._made.entries[space]]
        for name in name_registers(registers, self._scaled_by, self._exponents):
            self._made.notes.append(f"Line {self._lines[name]}: its factor is no number; 1 was taken.")
        if self._unnamed:
            shown = ", ".join(f"'{text}'" for text in list(self._unnamed)[:MOST_SHOWN])
            self._made.notes.append(f"Not read as names of values: {shown}.")

    def _assume(self, line: int, row: Mapping[str, str], space: str, entry: Mapping[str, Any], words: int) -> None:
        """Keep what other rows need, and note what is assumed."""
        name, scale, length = entry["name"], row.get("scale", ""), address_in(row.get("length", ""))
        self._names.add(name)
        self._lines[name] = line
        if entry.get("type") == "s16" and "sunssf" in row.get("type", "").casefold():
            self._exponents.add(name)
        is_open = space in SPACES[2:] and "scale" not in entry and scale.casefold() not in NOTHING
        product = PRODUCT.fullmatch(scale)
        if product is not None and space in SPACES[2:]:
            self._scaled_by[name] = self._as_name(product["name"])
        elif is_open and factor(scale, self._sheet.number) is None:
            self._scaled_by[name] = self._as_name(scale)
        if row.get("space") and space_of(row["space"]) is None:
            self._made.notes.append(f"Line {line}: {row['space']!r} is no table; {space.replace('_', ' ')} was taken.")
        words *= entry.get("count", 1)
        if length is not None and length not in (words, 2 * words, 16 * words) and space in SPACES[2:]:
            self._made.notes.append(f"Line {line}: its length is {length}, but {entry['type']} needs {words}.")
        if is_unsure(row):
            text = row.get("order") or row.get("type", "")
            self._made.notes.append(f"Line {line}: {text!r} was taken as the order DCBA; some mean CDAB by it.")

    def _leave_out(self, line: int, why: str) -> None:
        self._made.notes.append(f"Line {line} is left out: {' '.join(why.split())}.")

    def _entry(self, row: Mapping[str, str]) -> tuple[str, dict[str, Any]]:
        space, address = self._place(row)
        entry: dict[str, Any] = {"address": address, "name": self._name(row, space, address)}
        if space in SPACES[2:]:
            entry |= _type(row)
            entry |= {"unit": row["unit"]} if row.get("unit", "").casefold() not in NOTHING else {}
        entry |= self._values(row, entry.get("type", "bool"))
        access = access_of(row.get("access", ""))
        if access is not None and space in ("coils", "holding_registers"):
            entry["access"] = access
        about = " ".join(row.get("about", "").split())
        return space, entry | ({"about": about} if about and about != entry["name"] else {})

    def _place(self, row: Mapping[str, str]) -> tuple[str, int]:
        number = address_in(row["address"], is_hex=self._is_hex)
        if number is None:
            raise ValueError(f"{row['address']!r} is no address")
        space = space_of(row.get("space", ""))
        if self._is_numbered:
            numbered = NUMBERED.match(row["address"].replace(",", ""))
            if numbered is None:  # a spreadsheet has removed the zeros in front of a coil's
                return space or "coils", number - 1
            return space or FAMILIES[numbered[1]], int(numbered[2]) - 1
        if space is None:
            space = "coils" if _is_bit(row) else "holding_registers"
        if not 0 <= number <= 0xFFFF:
            raise ValueError(f"{number} is no address from 0 to 65535")
        return space, number

    def _name(self, row: Mapping[str, str], space: str, address: int) -> str:
        text = row.get("name") or row.get("about") or ""
        name = self._as_name(text)
        if not name:
            name = f"{space.removesuffix('s')}_{address}"
        name = name if not name[0].isdigit() else f"r_{name}"
        return name if name not in self._names else f"{name}_{address}"

    def _values(self, row: Mapping[str, str], type: str) -> dict[str, Any]:
        """Return what a row says of its values: scale, limits and start value, as far as the type has them."""
        if type == "bool":
            initial = self._sheet.number(row.get("initial", ""))
            return {"initial": True} if initial == 1 else {}
        if not type.startswith("string"):
            return self._numbers(row)
        return {"initial": row["initial"]} if row.get("initial") else {}

    def _numbers(self, row: Mapping[str, str]) -> dict[str, Any]:
        product = PRODUCT.fullmatch(row.get("scale", ""))
        scale = factor(row.get("scale", "") if product is None else product["factor"], self._sheet.number)
        divisor = self._sheet.number(row.get("divisor", ""))
        if divisor:
            scale = 1 / divisor
        numbers: dict[str, Any] = {} if scale in (None, 0, 1) else {"scale": _short(scale or 1)}
        offset = self._sheet.number(row.get("offset", ""))
        numbers |= {"offset": _short(offset)} if offset else {}
        names = values_in(row.get("values", ""))
        if row.get("values") and not names:
            self._unnamed[row["values"]] = None
        numbers |= {"values": names} if names else {}
        limits = {key: self._sheet.number(row.get(key, "")) for key in ONES}
        return numbers | {key: _short(value) for key, value in limits.items() if value is not None}


def _unread(sheet: Sheet, columns: Mapping[str, int]) -> Iterator[str]:
    """Yield what says that columns with contents have no meaning here."""
    filled = {place for row in sheet.rows for place, cell in enumerate(row) if cell.strip()}
    names = [name for place, name in enumerate(sheet.names) if name and place in filled - set(columns.values())]
    if names:
        yield f"Not read: {'the column' if len(names) == 1 else 'the columns'} {', '.join(names)}."


def _bit(row: Mapping[str, str]) -> int | None:
    """Return the bit of a register that a row is about; None for any other row."""
    is_truth = type_of(row.get("type", ""), None) == "bool"
    bit = bit_in(row.get("bit", ""), row["address"]) if _is_of_registers(row) else None
    return bit if is_truth or not row.get("type") else None


def _is_of_registers(row: Mapping[str, str]) -> bool:
    return space_of(row.get("space", "")) in (None, *SPACES[2:])


def _is_wrong_bit(row: Mapping[str, str]) -> bool:
    text = row.get("bit", "")
    return _is_of_registers(row) and text.casefold() not in NOTHING and bit_in(text, "") is None


def _is_bit(row: Mapping[str, str]) -> bool:
    is_alone = row.get("length", "") in ("", "1") and _bit(row) is None
    return type_of(row.get("type", ""), None) == "bool" and is_alone


def _as_name(text: str) -> str:
    return _joined(without_accents("".join(UMLAUTS.get(letter, letter) for letter in text)))


def _joined(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_").lower()[:60].strip("_")


def _rows(sheet: Sheet, columns: Mapping[str, int]) -> Iterator[tuple[int, dict[str, str]]]:
    for line, row in zip(sheet.lines, sheet.rows, strict=True):
        yield line, {what: row[place].strip() if place < len(row) else "" for what, place in columns.items()}


def _type(row: Mapping[str, str]) -> dict[str, Any]:
    """Return the type and the orders of a row; without a type, what its number of registers means."""
    text = row.get("type", "")
    length = address_in(row.get("length", ""))
    order = dict(ORDERS[order_of(row) or "abcd"])
    type = type_of(text, length) if text else TYPES_BY_WORDS.get(length or 1)
    array = re.search(r"\[(\d+)\]", text)
    if array is not None and type in ("u8", "s8"):  # a text in C
        type = "string[n]"
    if type == "string[n]":
        characters = re.search(r"\d+", text)
        count = int(characters[0]) if characters else 2 * (length or 8)
        type = f"string[{min(max(count, 1), 250)}]"
    if type in ("u8", "s8"):  # a register has 16 bits
        type = type.replace("8", "16")
    if type is None:
        raise ValueError(f"{text!r} is no type that is known" if text else f"no type has {length} registers")
    is_array = array is not None and not type.startswith("string") and int(array[1]) > 1
    return {"type": type} | order | ({"count": int(array[1])} if array and is_array else {})


def _short(number: float) -> int | float:
    rounded = float(f"{number:.12g}")
    return int(rounded) if rounded.is_integer() and abs(rounded) < 1e15 else rounded
