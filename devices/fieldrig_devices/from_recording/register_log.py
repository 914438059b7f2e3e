"""Registers of a recording, and the groups in which a master reads and writes them.

Source: Modbus application protocol V1.1b3, chapter 6, for the places of addresses and values in requests and responses.
"""

import struct
from array import array
from collections import Counter
from collections.abc import Iterator
from typing import Final, NamedTuple

from fieldrig_devices.from_recording.series import Room, Series
from fieldrig_devices.registers.table import SPACES

COILS, DISCRETE_INPUTS, HOLDING_REGISTERS, INPUT_REGISTERS = SPACES
READERS: Final = {1: COILS, 2: DISCRETE_INPUTS, 3: HOLDING_REGISTERS, 4: INPUT_REGISTERS, 23: HOLDING_REGISTERS}
"""The space that a function reads."""
BITS: Final = frozenset({COILS, DISCRETE_INPUTS})
WRITE_COIL, WRITE_REGISTER, WRITE_COILS, WRITE_REGISTERS, MASK_WRITE, READ_WRITE = 5, 6, 15, 16, 22, 23
ON: Final = 0xFF00
_TWO: Final = struct.Struct(">HH")


class Group(NamedTuple):
    """The addresses that a master reads or writes at once: function code, first address and quantity."""

    function: int
    address: int
    quantity: int

    @property
    def addresses(self) -> range:
        return range(self.address, min(self.address + self.quantity, 0x1_0000))


class RegisterLog:
    """One register or bit."""

    __slots__ = ("first", "is_moved", "is_read", "is_written", "last", "values", "written")

    def __init__(self, room: Room) -> None:
        self.is_read = self.is_written = self.is_moved = False
        self.first: int | None = None
        """The value of the first read before any write."""
        self.last: int | None = None
        self.values = Series(room)
        """The values that were read, and those that were written."""
        self.written: set[int] = set()
        """The places of what a client wrote, in `values`."""

    def read(self, time_ns: int, value: int) -> None:
        if not self.is_read and not self.is_written:
            self.first = value
        self.is_moved |= self.last is not None and value != self.last
        self.is_read, self.last = True, value
        self.values.take(time_ns, value)

    def write(self, time_ns: int, value: int) -> None:
        self.is_written, self.last = True, value
        count = len(self.values)
        self.values.take(time_ns, value)
        if len(self.values) > count:
            self.written.add(count)

    @property
    def start(self) -> int:
        """The value that the emulated device begins with: the one before any write, else the last one."""
        return (self.last or 0) if self.first is None else self.first


class GroupLog:
    """How a master uses a group."""

    def __init__(self) -> None:
        self.instants = array("q")
        self.count = 0
        self.refused: Counter[int] = Counter()
        """Exception codes."""
        self.refused_request = b""
        self.sample: tuple[bytes, bytes] | None = None
        """The first request with its response."""


def group_of(request: bytes) -> Group | None:
    """Return what a request names; None for a function without addresses, and for a request that is too short."""
    function = request[0]
    if function in (WRITE_COIL, WRITE_REGISTER, MASK_WRITE) and len(request) >= 5:
        return Group(function, int.from_bytes(request[1:3], "big"), 1)
    if (function in READERS or function in (WRITE_COILS, WRITE_REGISTERS)) and len(request) >= 5:
        return Group(function, *_TWO.unpack_from(request, 1))
    return None


def values_read(request: bytes, response: bytes) -> Iterator[tuple[str, int, int]]:
    """Yield space, address and value of what a response has; nothing if its length, or the request's, is wrong."""
    if len(request) < 5:
        return
    space = READERS[request[0]]
    address, quantity = _TWO.unpack_from(request, 1)
    data = response[2:]
    if space in BITS:
        if len(data) == (quantity + 7) // 8:
            yield from ((space, address + place, data[place // 8] >> place % 8 & 1) for place in range(quantity))
    elif len(data) == 2 * quantity:
        values = struct.unpack(f">{quantity}H", data)
        yield from ((space, address + place, value) for place, value in enumerate(values))


def values_written(request: bytes) -> Iterator[tuple[str, int, int]]:
    """Yield space, address and value of what a request writes."""
    function = request[0]
    if function in (WRITE_COIL, WRITE_REGISTER) and len(request) == 5:
        address, value = _TWO.unpack_from(request, 1)
        yield (COILS, address, int(value == ON)) if function == WRITE_COIL else (HOLDING_REGISTERS, address, value)
    elif function == WRITE_COILS and len(request) > 6:
        address, quantity = _TWO.unpack_from(request, 1)
        data = request[6:]
        if len(data) == (quantity + 7) // 8:
            yield from ((COILS, address + place, data[place // 8] >> place % 8 & 1) for place in range(quantity))
    elif function in (WRITE_REGISTERS, READ_WRITE):
        at = 1 if function == WRITE_REGISTERS else 5
        if len(request) >= at + 5:
            address, quantity = _TWO.unpack_from(request, at)
            data = request[at + 5 :]
            if len(data) == 2 * quantity:
                values = struct.unpack(f">{quantity}H", data)
                yield from ((HOLDING_REGISTERS, address + place, value) for place, value in enumerate(values))
