"""The markers %M of the program as Modbus registers and coils.

The map is ours (digest section 3: registers over the area %M).  Register 32768 + n is the word %MWn, so that the 32768
words of 64 kB fill the upper half of the address space.  Coil 32768 + n is bit n of the markers, counted from
%MX0.0; the 4096 bytes with single bits (PD-321) fill the upper half as well.  Bytes of a word are as on the
controller, low byte first, so a DWORD has its low word in the lower register.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, ModbusError
from fieldrig_bus.modbus.server import Bits, Registers

FIRST: Final = 0x8000
"""Address of the first marker, among registers and among coils."""

Markers = Callable[[], bytearray | None]
"""Return the area %M, or None while no program is loaded."""


class MarkerRegisters:
    """Registers of the controller, with the markers above FIRST."""

    def __init__(self, below: Registers, markers: Markers) -> None:
        self._below, self._markers = below, markers

    def read(self, address: int, quantity: int) -> bytes:
        if address < FIRST:
            return self._below.read(address, quantity)
        first, end = self._place(address, quantity)
        return _swapped(_area(self._markers)[first:end])

    def write(self, address: int, data: bytes) -> None:
        if address < FIRST:
            self._below.write(address, data)
            return
        first, end = self._place(address, len(data) // 2)
        _area(self._markers)[first:end] = _swapped(data)

    def _place(self, address: int, quantity: int) -> tuple[int, int]:
        first = 2 * (address - FIRST)
        end = first + 2 * quantity
        if end > len(_area(self._markers)):
            raise ModbusError(ILLEGAL_DATA_ADDRESS)
        return first, end


class MarkerBits:
    """Coils of the controller, with single bits of the markers above FIRST."""

    def __init__(self, below: Bits, markers: Markers) -> None:
        self._below, self._markers = below, markers

    def read(self, address: int, quantity: int) -> bytes:
        if address < FIRST:
            return self._below.read(address, quantity)
        area, first = _area(self._markers), self._place(address, quantity)
        packed = sum(1 << at for at in range(quantity) if area[(first + at) // 8] >> (first + at) % 8 & 1)
        return packed.to_bytes((quantity + 7) // 8, "little")

    def write(self, address: int, quantity: int, packed: bytes) -> None:
        if address < FIRST:
            self._below.write(address, quantity, packed)
            return
        area, first = _area(self._markers), self._place(address, quantity)
        for at in range(quantity):
            byte, bit = divmod(first + at, 8)
            is_on = packed[at // 8] >> at % 8 & 1
            area[byte] = area[byte] & ~(1 << bit) | is_on << bit

    @staticmethod
    def _place(address: int, quantity: int) -> int:
        first = address - FIRST
        if first + quantity > FIRST:
            raise ModbusError(ILLEGAL_DATA_ADDRESS)
        return first


def _area(markers: Markers) -> bytearray:
    """Return the area; without a program there are no markers."""
    area = markers()
    if area is None:
        raise ModbusError(ILLEGAL_DATA_ADDRESS)
    return area


def _swapped(data: bytes | bytearray) -> bytes:
    """Exchange the two bytes of each word: registers have the high byte first."""
    swapped = bytearray(len(data))
    swapped[0::2], swapped[1::2] = data[1::2], data[0::2]
    return bytes(swapped)
