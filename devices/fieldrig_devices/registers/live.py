"""Registers and bits whose values are computed when a client reads them, and that act when a client writes them.

They implement the protocols `Registers` and `Bits` of fieldrig_bus.modbus.server.  A write takes effect as a whole or
not at all: each value is checked before the first one is written.  Our choice where the specification leaves room: a
value of several registers acts when its last register, the one with the highest address, is written; until then reads
return its old value.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from fieldrig.device import Value
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, SERVER_DEVICE_FAILURE, ModbusError
from fieldrig_devices.registers.form import ByteOrder, Form, WordOrder, words_in

RESERVED: Final = "reserved"
BOOL: Final = "bool"


def any_value(_value: Value) -> None:
    """A check that accepts every value."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One value.  `type` is one of the register table.  Without `write` it is read-only for clients."""

    address: int
    name: str
    type: str
    read: Callable[[], Value]
    write: Callable[[Value], None] | None = None
    check: Callable[[Value], None] = any_value
    """Raises ValueError to refuse a value; the request is then answered with an exception and has no effect."""
    unit: str = ""
    about: str = ""

    def checked_by(self, check: Callable[[Value], None]) -> "Entry":
        return replace(self, check=check)

    @property
    def words(self) -> int:
        """Number of registers of the value."""
        return words_in(self.type)

    @property
    def end(self) -> int:
        return self.address + self.words


def whole(entries: Iterable[Entry], size: int) -> Iterator[Entry]:
    """Fill the gaps between the entries, and up to `size` registers, with reserved registers that clients can read."""
    at = first = -1
    for entry in sorted(entries, key=lambda entry: entry.address):
        if first < 0:
            at = first = entry.address
        yield from (_reserved(address) for address in range(at, entry.address))
        yield entry
        at = entry.end
    yield from (_reserved(address) for address in range(at, first + size))


def _reserved(address: int) -> Entry:
    return Entry(address, RESERVED, "u16", lambda: 0)


class LiveRegisters:
    """The registers of one unit."""

    def __init__(
        self,
        entries: Iterable[Entry],
        word_order: WordOrder = "big",
        refusal: int = SERVER_DEVICE_FAILURE,
        byte_order: ByteOrder = "big",
    ) -> None:
        """`refusal` is the exception code of a value that `check` refuses."""
        self._refusal = refusal
        self._at: dict[int, Entry] = {}
        self._forms: dict[str, Form] = {}
        for entry in entries:
            self._forms.setdefault(entry.type, Form(entry.type, word_order, byte_order))
            for address in range(entry.address, entry.end):
                self._at[address] = entry
        self._half: dict[int, bytes] = {}
        """Partly written values by their first addresses."""

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
        """The values in these registers.  ModbusError if any register does not exist."""
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
        """The bytes of a value, limited to the range of its type."""
        form = self._forms[entry.type]
        if entry.type == BOOL:
            return form.pack_truth(bool(value))
        if not form.is_number:
            return form.pack_text(str(value).encode("latin-1", "replace"))
        return form.pack(float(value) if form.is_float else min(max(int(value), form.low), form.high))

    def _decode(self, entry: Entry, raw: bytes) -> Value:
        form = self._forms[entry.type]
        if entry.type == BOOL:
            return any(raw)
        return form.unpack(raw) if form.is_number else form.unpack_text(raw)


@dataclass(frozen=True, slots=True)
class BitEntry:
    """One bit.  Without `write` it is read-only for clients."""

    address: int
    name: str
    read: Callable[[], bool]
    write: Callable[[bool], None] | None = None


class LiveBits:
    """The bits of one unit."""

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
