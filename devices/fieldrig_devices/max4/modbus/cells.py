"""Registers and bits with a program behind them: read when asked for, acting when written.

Keeps the protocols `Registers` and `Bits` of fieldrig_bus.modbus.server.  All of one request take effect, or none: each
value is checked before the first one is written.  Where the specification leaves the choice: a value of several
registers acts when its last register, the one with the highest address, is written; until then reads show it as it was.
"""

import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from fieldrig.device import Value
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, SERVER_DEVICE_FAILURE, ModbusError
from fieldrig_devices.registers.table import FLOATS, FORMATS, WORDS, WordOrder

RESERVED: Final = "reserved"


def any_value(_value: Value) -> None:
    """A check that everything passes."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One value; `type` is u16, s16, u32, s32, f64 or string[n].  Without `write` clients only read it."""

    address: int
    name: str
    type: str
    read: Callable[[], Value]
    write: Callable[[Value], None] | None = None
    check: Callable[[Value], None] = any_value
    """ValueError: the request is answered with exception 04, and nothing of it is done."""
    unit: str = ""
    about: str = ""

    def checked_by(self, check: Callable[[Value], None]) -> "Entry":
        return replace(self, check=check)

    @property
    def words(self) -> int:
        return WORDS[self.type] if self.type in WORDS else (self.characters + 1) // 2

    @property
    def characters(self) -> int:
        return int(self.type[7:-1])

    @property
    def end(self) -> int:
        return self.address + self.words


def whole(entries: Iterable[Entry], size: int) -> Iterator[Entry]:
    """With what is reserved between them, and up to `size` from the first one on: reads can go over it."""
    at = first = -1
    for entry in sorted(entries, key=lambda one: one.address):
        if first < 0:
            at = first = entry.address
        yield from (_reserved(address) for address in range(at, entry.address))
        yield entry
        at = entry.end
    yield from (_reserved(address) for address in range(at, first + size))


def _reserved(address: int) -> Entry:
    return Entry(address, RESERVED, "u16", lambda: 0)


class LiveRegisters:
    def __init__(
        self, entries: Iterable[Entry], word_order: WordOrder = "big", refusal: int = SERVER_DEVICE_FAILURE
    ) -> None:
        """`refusal` is the exception code for a value that is refused."""
        self._is_little, self._refusal = word_order == "little", refusal
        self._at: dict[int, Entry] = {}
        for entry in entries:
            for address in range(entry.address, entry.end):
                self._at[address] = entry
        self._half: dict[int, bytes] = {}
        """By first address: what of a value is written so far."""

    def read(self, address: int, quantity: int) -> bytes:
        entries = self._touched(address, quantity)
        data = b"".join(self._encode(entry, entry.read()) for entry in entries)
        start = 2 * (address - entries[0].address)
        return data[start : start + 2 * quantity]

    def write(self, address: int, data: bytes) -> None:
        quantity = len(data) // 2
        entries = self._touched(address, quantity)
        half: dict[int, bytes] = {}
        actions: list[tuple[Callable[[Value], None], Value]] = []
        for entry in entries:
            if entry.write is None:
                raise ModbusError(ILLEGAL_DATA_ADDRESS)
            raw = self._patched(entry, address, data)
            if entry.end > address + quantity:
                half[entry.address] = raw
            else:
                actions.append((entry.write, self._checked(entry, raw)))
        for entry in entries:
            self._half.pop(entry.address, None)
        self._half.update(half)
        for act, value in actions:
            act(value)

    def _touched(self, address: int, quantity: int) -> list[Entry]:
        """The values from `address` on.  ModbusError if anything is not there."""
        entries: list[Entry] = []
        at, end = address, address + quantity
        while at < end:
            entry = self._at.get(at)
            if entry is None:
                raise ModbusError(ILLEGAL_DATA_ADDRESS)
            entries.append(entry)
            at = entry.end
        return entries

    def _patched(self, entry: Entry, address: int, data: bytes) -> bytes:
        raw = bytearray(self._half.get(entry.address) or self._encode(entry, entry.read()))
        first, last = max(entry.address, address), min(entry.end, address + len(data) // 2)
        raw[2 * (first - entry.address) : 2 * (last - entry.address)] = data[
            2 * (first - address) : 2 * (last - address)
        ]
        return bytes(raw)

    def _checked(self, entry: Entry, raw: bytes) -> Value:
        value = self._decode(entry, raw)
        try:
            entry.check(value)
        except ValueError as cause:
            raise ModbusError(self._refusal) from cause
        return value

    def _encode(self, entry: Entry, value: Value) -> bytes:
        """What doesn't fit shows the end of the type."""
        kind = FORMATS.get(entry.type)
        if kind is None:
            text = str(value).encode("latin-1", "replace")[: entry.characters]
            return text.ljust(2 * entry.words, b"\x00")
        number = float(value) if entry.type in FLOATS else _limited(entry, int(value))
        data = struct.pack(f">{kind}", number)
        return _swapped(data) if self._is_little else data

    def _decode(self, entry: Entry, raw: bytes) -> Value:
        kind = FORMATS.get(entry.type)
        if kind is None:
            return raw.split(b"\x00")[0].decode("latin-1")
        value: int | float = struct.unpack(f">{kind}", _swapped(raw) if self._is_little else raw)[0]
        return value


def _limited(entry: Entry, number: int) -> int:
    bits = 16 * entry.words
    low, high = (0, (1 << bits) - 1) if entry.type.startswith("u") else (-(1 << bits - 1), (1 << bits - 1) - 1)
    return min(max(number, low), high)


def _swapped(data: bytes) -> bytes:
    """The low word first."""
    return b"".join(data[at : at + 2] for at in range(len(data) - 2, -1, -2))


@dataclass(frozen=True, slots=True)
class BitEntry:
    address: int
    name: str
    read: Callable[[], bool]
    write: Callable[[bool], None] | None = None


class LiveBits:
    def __init__(self, entries: Sequence[BitEntry]) -> None:
        self._at = {entry.address: entry for entry in entries}

    def read(self, address: int, quantity: int) -> bytes:
        packed = sum(1 << place for place, entry in enumerate(self._touched(address, quantity)) if entry.read())
        return packed.to_bytes((quantity + 7) // 8, "little")

    def write(self, address: int, quantity: int, packed: bytes) -> None:
        entries = self._touched(address, quantity)
        if any(entry.write is None for entry in entries):
            raise ModbusError(ILLEGAL_DATA_ADDRESS)
        for place, entry in enumerate(entries):
            assert entry.write is not None
            entry.write(bool(packed[place // 8] >> place % 8 & 1))

    def _touched(self, address: int, quantity: int) -> list[BitEntry]:
        try:
            return [self._at[number] for number in range(address, address + quantity)]
        except KeyError as cause:
            raise ModbusError(ILLEGAL_DATA_ADDRESS) from cause
