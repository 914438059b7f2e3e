"""The memory of a loaded program, and what generated code cannot do inline: pointers to another type, areas, checks.

A pointer that is used with another type than that of the cells that it points to reads or writes their bytes, as on the
controller, which is little-endian.
"""

import re
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final, NamedTuple

from fieldrig_devices.iec import characters
from fieldrig_devices.iec.carrying import Run
from fieldrig_devices.iec.cell_bytes import BY_NUMBER, TEXTS, decoded, encoded, text_bytes, text_in
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.exceptions import thrown
from fieldrig_devices.iec.host import Host
from fieldrig_devices.iec.images import Images
from fieldrig_devices.iec.layout import (
    AREA_SIZE,
    AREAS,
    DATA,
    INSIDE,
    STACK_SIZE,
    STACKS,
    STRING_KIND,
    WIDE_STRING_KIND,
    kind_number,
    storage,
)
from fieldrig_devices.iec.library.integers import cut
from fieldrig_devices.iec.lower.names import CUTS, REALS
from fieldrig_devices.iec.lower.texts import FASTER
from fieldrig_devices.iec.types import StringType, Type, Value
from fieldrig_devices.languages.faults import RunError

_INSIDE: Final = INSIDE[0]
_BEGIN: Final = re.compile(b"[^" + re.escape(INSIDE) + b"]", re.DOTALL)
"""The kind of a cell that is not within a value."""
_UNKNOWN: Final = bytes(STACK_SIZE)
BLOCK: Final = 8
"""Bytes that memory for single bytes is a multiple of."""
MOST_ALLOCATED: Final = 64 << 20
"""Bytes that a program may have from __NEW."""
UNTOUCHED: Final = 8
"""Variables of a size that keep their contents after they are deleted; the one before them is used again."""
ROOM_TO_GROW: Final = 65_536
"""Bytes between the variables of a program and what __NEW gives."""
_LONGEST_VALUE: Final = 2_000_002
"""Bytes of the largest value, a WSTRING(1000000)."""


def limited(value: Value, kind: Type) -> Value:
    """Return a value from the host as one of the type; numbers are cut, strings shortened."""
    return limiter(kind)(value)


def limiter(kind: Type) -> Callable[[Value], Value]:
    """Return `limited` for one type."""
    stored = storage(kind)
    if isinstance(stored, StringType):
        length, known = stored.length, characters.widened if stored.is_wide else characters.narrowed
        return lambda value: known(str(value))[:length]
    assert stored is not None
    if stored is Elementary.BOOL:
        return bool
    if stored is Elementary.LREAL:
        return float
    if stored is Elementary.REAL:
        return lambda value: array("f", [float(value)])[0]
    low, high, number = stored.low, stored.high, stored
    return lambda value: whole if low <= (whole := int(value)) <= high else cut(whole, number)


class Kept(NamedTuple):
    """The contents of the memory at an instant: all variables, and what __NEW has given."""

    cells: Sequence[Value]
    kinds: bytes
    allocated: Mapping[int, int]
    free: Mapping[int, Sequence[int]]


class Memory:
    def __init__(self, host: Host, areas: Mapping[str, bytearray], images: Images, end: int) -> None:
        """`areas` are the contents of %I, %Q and %M; the cells reach up to `end`, the end of the program's layout."""
        self._host, self._areas, self._images = host, areas, images
        self._forms: Sequence[Type] = ()
        """The types that generated code names by number."""
        self._form_kinds: dict[int, bytes] = {}
        """The kinds of their cells, by that number, because looking for a type takes longer than checking a pointer."""
        self.cells: list[Value] = [0] * end
        self.kinds = bytearray(end)
        """The kind of the value that begins at a cell (`layout.KINDS`), INSIDE within a value, and 0 if unknown."""
        self._program_end = end
        self._allocated: dict[int, int] = {}
        """The sizes of what __NEW has given, by address."""
        self._free: dict[int, list[int]] = {}
        """Addresses of memory that was given back, by size."""
        self._written: dict[int, tuple[Value, bytes]] = {}
        """All bytes of strings that have some behind their closing zero, by the address, with the text in front of it.

        A program that fills a string from its end through a pointer, as OSCAT does, finds them when it closes the gap.
        """

    # ---- the heap

    def allocate(self, form: int, count: int) -> int:
        """Return the address of new variables of a type, with their start values; 0 if there is no room for them.

        Bytes fill whole blocks, as on a controller, where a WSTRING in three bytes can be read up to its closing zero.
        """
        kind = self._forms[form]
        if kind.size == 1:
            count = -(-count // BLOCK) * BLOCK
        size = kind.size * count
        if not size or len(self.cells) + size > self._program_end + MOST_ALLOCATED:
            return 0
        free = self._free.get(size, [])
        is_used_again = len(free) > UNTOUCHED
        address = free.pop(0) if is_used_again else max(len(self.cells), self._program_end + ROOM_TO_GROW)
        self._allocated[address] = size
        self._extend(address + size)
        self.put_image(address, self._images.cells(kind) * count, self._images.kinds(kind) * count)
        return address

    def free(self, address: int) -> None:
        """Take the memory of variables back; an address that nothing was given at is left alone.

        Its contents stay until it is used again, as on a controller: programs read what they have just deleted.
        """
        size = self._allocated.pop(address, 0)
        if size:
            self._free.setdefault(size, []).append(address)

    def is_allocated(self, address: int, size: int) -> bool:
        """True if these bytes are in memory that __NEW has given and that was not given back."""
        whole = self._allocated.get(address)
        if whole is not None:
            return size <= whole
        return any(first <= address and address + size <= first + whole for first, whole in self._allocated.items())

    def is_of_program(self, address: int, size: int) -> bool:
        """True if these bytes are in variables of the program, not on the stack of a task."""
        return address >= DATA and address + size <= self._program_end

    def free_all(self) -> None:
        """Take all such memory back."""
        self._allocated.clear()
        self._free.clear()
        start = self._program_end + ROOM_TO_GROW
        del self.cells[start:], self.kinds[start:]

    def _extend(self, end: int) -> None:
        missing = end - len(self.cells)
        if missing > 0:
            self.cells += [0] * missing
            self.kinds += bytes(missing)

    def grow(self, end: int) -> None:
        """Make room for a program up to `end`.

        What a program has made with __NEW lies behind it, with some room for larger programs between them; of an even
        larger one it is in the way, and is taken back.
        """
        if self._allocated and end > self._program_end + ROOM_TO_GROW:
            self.free_all()
        if not self._allocated:
            self._program_end = end
        self._extend(end)

    def put_image(self, address: int, cells: Sequence[Value], kinds: bytes) -> None:
        self.cells[address : address + len(cells)] = cells
        self.kinds[address : address + len(kinds)] = kinds

    def image(self, address: int, size: int) -> tuple[Sequence[Value], bytes]:
        """Return cells with their kinds."""
        return self.cells[address : address + size], bytes(self.kinds[address : address + size])

    def kept(self) -> "Kept":
        """Return the contents of the data area, for `restore`."""
        free = {size: list(addresses) for size, addresses in self._free.items()}
        return Kept(self.cells[DATA:], bytes(self.kinds[DATA:]), dict(self._allocated), free)

    def restore(self, kept: "Kept", parts: Sequence[range] | None = None) -> None:
        """Give the data area contents that it had before, and forget what was on the first stack.

        With `parts`, only those addresses can have changed, unless the program has made variables by itself.
        """
        if parts is None or len(self.cells) != DATA + len(kept.cells):
            self.cells[DATA:], self.kinds[DATA:] = kept.cells, kept.kinds
        else:
            for part in parts:
                there = slice(part.start - DATA, part.stop - DATA)
                self.cells[part.start : part.stop] = kept.cells[there]
                self.kinds[part.start : part.stop] = kept.kinds[there]
        self._allocated = dict(kept.allocated)
        self._free = {size: list(addresses) for size, addresses in kept.free.items()}
        self.kinds[STACKS : STACKS + STACK_SIZE] = _UNKNOWN
        self._written.clear()

    def put_runs(self, address: int, runs: Iterable[Run], cells: Sequence[Value], kinds: bytes) -> None:
        """Put runs of an image into the variable at an address."""
        for source, target, size in runs:
            self.put_image(address + target, cells[source : source + size], kinds[source : source + size])

    def use_forms(self, forms: Sequence[Type]) -> None:
        self._forms = forms
        self._form_kinds.clear()

    # ---- pointers

    def value(self, address: int, number: int) -> Value:
        """Read a value that may be of another type."""
        return self.cells[address] if self.kinds[address] == number else self.peek(address, number)

    def put_value(self, address: int, number: int, value: Value) -> None:
        """Write a value where there may be one of another type."""
        if self.kinds[address] == number:
            self.cells[address] = value
        else:
            self.poke(address, number, value)

    def value_of(self, address: int, kind: Elementary) -> Value:
        """Return the value of an elementary type at an address."""
        return self.value(address, kind_number(kind))

    def text_of(self, address: int, *, is_wide: bool) -> str:
        """Return the text at an address."""
        return str(self.peek(address, WIDE_STRING_KIND if is_wide else STRING_KIND))

    def bytes_at(self, address: int, size: int) -> bytes:
        """Return the bytes that a program has in its memory; RunError if there are none."""
        return self._bytes(address, size)

    def put_bytes_at(self, address: int, data: bytes) -> None:
        """Give a program bytes in its memory; RunError if it has none there."""
        self._put_bytes(address, data)

    def check_bytes(self, address: int, size: int) -> None:
        """RunError if a program does not have these bytes in its memory."""
        if self._area(address, size) is None:
            self._check(address, size)

    def copy_cells(self, target: int, source: int, size: int) -> bool:
        """Copy bytes that have whole values of the same kinds in both places; return whether they have."""
        ends = max(target, source) + size
        if min(target, source) < STACKS or ends > len(self.cells) or self._written:
            return False
        kinds = self.kinds[source : source + size]
        is_whole = kinds[0] != _INSIDE and self.kinds[source + size : source + size + 1] != INSIDE
        is_whole = is_whole and self.kinds[target + size : target + size + 1] != INSIDE
        if not is_whole or self.kinds[target : target + size] != kinds:
            return False
        self.cells[target : target + size] = self.cells[source : source + size]
        return True

    def peek(self, address: int, number: int) -> Value:
        """Read a value through a pointer whose target begins otherwise."""
        if number in TEXTS:
            return self._string(address, number)
        kind = BY_NUMBER[number]
        if self._is_unmarked(address):
            return limited(self.cells[address] if not isinstance(self.cells[address], str) else 0, kind)
        return decoded(self._bytes(address, kind.size), number)

    def poke(self, address: int, number: int, value: Value) -> None:
        if self._is_unmarked(address):
            self.cells[address] = value
            return
        if number in TEXTS:
            assert isinstance(value, str)
            self._put_bytes(address, text_bytes(value, number) + bytes(TEXTS[number]))
        else:
            self._put_bytes(address, encoded(value, number))

    def peek_cells(self, address: int, form: int) -> list[Value]:
        kinds, size = self._form(form)
        if self.kinds[address : address + size] == kinds:
            return self.cells[address : address + size]
        values: list[Value] = [0] * size
        for offset, number in enumerate(kinds):
            if number != _INSIDE:
                values[offset] = self.peek(address + offset, number)
        return values

    def swapped_cells(self, cells: Sequence[Value], form: int) -> list[Value]:
        """Return the cells of a type with the bytes of each value in the opposite order; texts stay as they are."""
        swapped = [*cells]
        for offset, number in enumerate(self._form(form)[0]):
            if number != _INSIDE and number not in TEXTS and BY_NUMBER[number].size > 1:
                swapped[offset] = decoded(encoded(swapped[offset], number)[::-1], number)
        return swapped

    def poke_cells(self, address: int, form: int, cells: list[Value]) -> None:
        kinds, size = self._form(form)
        if self.kinds[address : address + size] == kinds:
            self.cells[address : address + size] = cells
            return
        for offset, number in enumerate(kinds):
            if number != _INSIDE:
                self.poke(address + offset, number, cells[offset])

    def of_form(self, address: int, form: int) -> int:
        """Return the address if something of this type is there."""
        kinds, size = self._form(form)
        if self.kinds[address : address + size] != kinds and not self._take_form(address, form):
            what = f"the pointer does not point to {self._forms[form]}" if address else "a pointer to nothing"
            raise RunError("pointer", what)
        return address

    def _take_form(self, address: int, form: int) -> bool:
        """Give bytes of __NEW another type, and return whether there is room for it; a string takes what there is.

        Programs make `__NEW(BYTE, n)` and hand `p^` on as a STRING or a structure.
        """
        ends = (first + size for first, size in self._allocated.items() if first <= address < first + size)
        room, (kinds, size) = next(ends, address) - address, self._form(form)
        if kinds[:1] in (bytes([STRING_KIND]), bytes([WIDE_STRING_KIND])) and size > room > 0:
            kinds, size = kinds[:room], room
        if size > room or INSIDE in (
            self.kinds[address : address + 1],
            self.kinds[address + size : address + size + 1],
        ):
            return False
        data = self._bytes(address, size)
        self.kinds[address : address + size] = kinds
        self.cells[address : address + size] = ["" if number in TEXTS else 0 for number in kinds]
        self._put_bytes(address, data)
        return True

    def mark(self, address: int, form: int) -> int:
        """Note the kinds of a variable on the stack, because a pointer to it is made."""
        kinds, size = self._form(form)
        self.kinds[address : address + size] = kinds
        return address

    def mark_on_stack(self, address: int, form: int) -> int:
        """Note the kinds of a variable in the same way if it is on the stack; all others have theirs."""
        return self.mark(address, form) if STACKS <= address < DATA else address

    def _form(self, form: int) -> tuple[bytes, int]:
        kinds = self._form_kinds.get(form)
        if kinds is None:
            kinds = self._form_kinds[form] = self._images.kinds(self._forms[form])
        return kinds, len(kinds)

    def _is_unmarked(self, address: int) -> bool:
        return STACKS <= address < DATA and not self.kinds[address]

    def _area(self, address: int, size: int) -> tuple[bytearray, int, str] | None:
        """Return the area, the number of the byte in it, and its letter, if the address is in %I, %Q or %M."""
        for letter, start in AREAS.items():
            if start <= address <= start + AREA_SIZE - size and address - start + size <= len(self._areas[letter]):
                return self._areas[letter], address - start, letter
        return None

    def _check(self, address: int, size: int) -> None:
        if address < AREAS["I"]:
            raise RunError("pointer", "a pointer to nothing" if address == 0 else "a pointer to no variable")
        if not STACKS <= address <= len(self.cells) - size:
            raise RunError("pointer", "a pointer to no variable")

    def _bytes(self, address: int, size: int) -> bytes:
        area = self._area(address, size)
        if area is not None:
            table, byte, _ = area
            return bytes(table[byte : byte + size])
        self._check(address, size)
        read = bytearray(size)
        for start, data in self._values(address, size):
            part = data[max(0, address - start) : address + size - start]
            offset = max(0, start - address)
            read[offset : offset + len(part)] = part
        return bytes(read)

    def _put_bytes(self, address: int, data: bytes) -> None:
        area = self._area(address, len(data))
        if area is not None:
            table, byte, letter = area
            table[byte : byte + len(data)] = data
            if letter == "Q":
                for number in range(byte, byte + len(data)):
                    self._host.on_output(number)
            return
        self._check(address, len(data))
        for start, old in self._values(address, len(data)):
            new, part = bytearray(old), data[max(0, start - address) : start + len(old) - address]
            offset = max(0, address - start)
            new[offset : offset + len(part)] = part
            self.cells[start] = value = self._decoded(bytes(new), self.kinds[start])
            if self.kinds[start] in TEXTS:
                self._keep_behind(start, value, bytes(new))

    def _values(self, address: int, size: int) -> list[tuple[int, bytes]]:
        """Return the values that have a byte from `address` on, with their addresses."""
        start = address
        while start > STACKS and self.kinds[start] == _INSIDE:
            start -= 1
        values = []
        while start < address + size:
            data = self._encoded(start) if self.kinds[start] not in (0, _INSIDE) else b""
            if data:
                values.append((start, data))
            start += len(data) or 1
        return values

    def _encoded(self, address: int) -> bytes:
        number, value = self.kinds[address], self.cells[address]
        if number not in TEXTS:
            return encoded(value, number)
        room, (known, whole) = self._room(address), self._written.get(address, ("", b""))
        if known == value and len(whole) == room:
            return whole
        return text_bytes(str(value), number).ljust(room, b"\0")

    def _keep_behind(self, address: int, value: Value, data: bytes) -> None:
        """Keep the bytes of a string if there are any behind its closing zero."""
        if data.rstrip(b"\0") != text_bytes(str(value), self.kinds[address]).rstrip(b"\0"):
            self._written[address] = value, data
        else:
            self._written.pop(address, None)

    def _decoded(self, data: bytes, number: int) -> Value:
        return text_in(data, number) if number in TEXTS else decoded(data, number)

    def _room(self, address: int) -> int:
        """Return the size of the string at an address."""
        end = _BEGIN.search(self.kinds, address + 1)
        return (end.start() if end is not None else len(self.kinds)) - address

    def _string(self, address: int, number: int) -> str:
        width = TEXTS[number]
        if self._area(address, 1) is None:
            self._check(address, 1)
            if self.kinds[address] == number:
                return str(self.cells[address])
        text = bytearray()
        while len(text) < _LONGEST_VALUE // 2 * width - width:
            character = self._bytes(address + len(text), width)
            if not any(character):
                break
            text += character
        return text_in(bytes(text), number)

    # ---- what generated code calls

    def names(self) -> dict[str, Any]:
        """Return the names of generated code that belong to the memory."""
        return {
            "M": self.cells,
            "K": self.kinds,
            "F": array("f", [0.0] * REALS),
            "I": self._areas["I"],
            "Q": self._areas["Q"],
            "X": self._areas["M"],
            "INFINITY": float("inf"),
            "NAN": float("nan"),
            "peek": self.peek,
            "poke": self.poke,
            "peek_cells": self.peek_cells,
            "poke_cells": self.poke_cells,
            "swapped_cells": self.swapped_cells,
            "of_form": self.of_form,
            "mark": self.mark,
            "mark_on_stack": self.mark_on_stack,
            "allocate": self.allocate,
            "free": self.free,
            "fetch": self.peek,
            "put": self.poke,
            "on_output": self._host.on_output,
            "outside_array": outside_array,
            "outside_range": outside_range,
            "null_reference": null_reference,
            "thrown": thrown,
            **FASTER,
            **{name: _cutter(kind) for kind, name in CUTS.items()},
        }


def _cutter(kind: Elementary) -> Callable[[int], int]:
    return lambda value: cut(value, kind)


def outside_array(index: int, low: int, high: int) -> None:
    raise RunError("array bounds", f"the index {index} is outside {low}..{high}")


def outside_range(value: int, *ends: int) -> None:
    """Report a value that is in none of some ranges; `ends` are their first and last numbers."""
    ranges = [f"{low}..{high}" if low < high else f"{low}" for low, high in zip(ends[::2], ends[1::2], strict=True)]
    raise RunError("subrange", f"the value {value} is outside {', '.join(ranges)}")


def null_reference() -> None:
    raise RunError("pointer", "a VAR_IN_OUT that has never been given")
