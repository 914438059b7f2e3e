"""The registers and bits of one Modbus unit as bytes that are ready to be sent, so that a read is a slice.

Our choice where the specification leaves room: a value of several registers takes effect (limits, wire, non-volatile
memory) when its last register, the one with the highest address, is written; until then it is only registers.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, ModbusError


class Area(NamedTuple):
    """A range of addresses that exist, and the access that clients have to them."""

    address: int
    size: int
    is_readable: bool
    is_writable: bool


class BitWatcher(Protocol):
    """Something that acts when a client writes a bit."""

    def on_written(self) -> None:
        """Act on a bit that a client has written."""


class Watcher(Protocol):
    """Something that limits the value in some registers, and acts when a client writes it."""

    def limited(self, data: bytes) -> bytes:
        """Return the bytes for the registers when a client writes `data`.  ModbusError if the client may not."""

    def on_written(self) -> None:
        """Act on a value that a client has written."""


Commit = Callable[[Sequence[Any]], None]
"""Called with the watchers of the written values when the new values are in place.  ModbusError if they cannot be
stored; then the old values are restored, and no watcher is called."""


def _commit_nothing(_watchers: Sequence[Any]) -> None:
    pass


class _Map:
    """The access to each address from `base` up to but not including `end`: 1 if it is allowed."""

    def __init__(self, areas: Sequence[Area]) -> None:
        self.base = min((area.address for area in areas), default=0)
        self.end = max((area.address + area.size for area in areas), default=0)
        self.readable, self.writable = bytearray(self.end - self.base), bytearray(self.end - self.base)
        for address, size, is_readable, is_writable in areas:
            place = slice(address - self.base, address - self.base + size)
            self.readable[place] = bytes((is_readable,)) * size
            self.writable[place] = bytes((is_writable,)) * size

    def start(self, address: int, quantity: int, allowed: bytearray) -> int:
        """The index of `address`.  ModbusError if any address of the quantity does not exist or is not allowed."""
        start = address - self.base
        if start < 0 or address + quantity > self.end or allowed.find(0, start, start + quantity) >= 0:
            raise ModbusError(ILLEGAL_DATA_ADDRESS)
        return start


class RegisterImage:
    """The registers of one space as bytes."""

    def __init__(self, areas: Sequence[Area], commit: Commit = _commit_nothing) -> None:
        self._commit = commit
        self._map = _Map(areas)
        self._base, self._end, self._readable = self._map.base, self._map.end, self._map.readable
        self._image = bytes(2 * (self._end - self._base))  # not a bytearray: there are more reads than writes
        self._watched: dict[int, tuple[int, Watcher]] = {}  # first address and watcher by last address

    def watch(self, address: int, words: int, watcher: Watcher) -> None:
        self._watched[address + words - 1] = (address, watcher)

    def get(self, address: int, words: int) -> bytes:
        start = 2 * (address - self._base)
        return self._image[start : start + 2 * words]

    def put(self, address: int, data: bytes) -> None:
        """Write without access checks and without calling watchers."""
        start = 2 * (address - self._base)
        self._image = self._image[:start] + data + self._image[start + len(data) :]

    def read(self, address: int, quantity: int) -> bytes:
        start = address - self._base  # `_Map.start` without the call, as this is the hot path of polling
        stop = start + quantity
        if start < 0 or address + quantity > self._end or self._readable.find(0, start, stop) >= 0:
            raise ModbusError(ILLEGAL_DATA_ADDRESS)
        return self._image[2 * start : 2 * stop]

    def write(self, address: int, data: bytes) -> None:
        quantity = len(data) // 2
        self._map.start(address, quantity, self._map.writable)
        watched = self._watched
        complete = [(last, *watched[last]) for last in range(address, address + quantity) if last in watched]
        before = self._image
        self.put(address, data)
        try:
            for last, first, watcher in complete:
                self.put(first, watcher.limited(self.get(first, last - first + 1)))
            if complete:
                self._commit([watcher for _, _, watcher in complete])
        except ModbusError:
            self._image = before
            raise
        for _, _, watcher in complete:
            watcher.on_written()


class BitImage:
    """The bits of one space, kept as the digits 0 and 1 because `int(digits, 2)` packs them all at once."""

    def __init__(self, areas: Sequence[Area], commit: Commit = _commit_nothing) -> None:
        self._commit = commit
        self._map = _Map(areas)
        self._digits = bytearray(b"0" * (self._map.end - self._map.base))
        self._watched: dict[int, BitWatcher] = {}

    def watch(self, address: int, watcher: "BitWatcher") -> None:
        self._watched[address] = watcher

    def get(self, address: int) -> bool:
        return self._digits[address - self._map.base] == ord("1")

    def put(self, address: int, value: bool) -> None:
        """Write without access checks and without calling watchers."""
        self._digits[address - self._map.base] = ord("1" if value else "0")

    def read(self, address: int, quantity: int) -> bytes:
        start = self._map.start(address, quantity, self._map.readable)
        packed = int(self._digits[start : start + quantity][::-1], 2)
        return packed.to_bytes((quantity + 7) // 8, "little")

    def write(self, address: int, quantity: int, packed: bytes) -> None:
        start = self._map.start(address, quantity, self._map.writable)
        value = int.from_bytes(packed, "little") & (1 << quantity) - 1
        place, watched = slice(start, start + quantity), self._watched
        before = self._digits[place]
        self._digits[place] = f"{value:0{quantity}b}".encode()[::-1]
        complete = [watched[written] for written in range(address, address + quantity) if written in watched]
        if complete:
            try:
                self._commit(complete)
            except ModbusError:
                self._digits[place] = before
                raise
        for watcher in complete:
            watcher.on_written()
