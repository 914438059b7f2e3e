"""The memory as Modbus registers: register n is word n, as a holding register and as an input register."""

import struct

from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, ModbusError
from fieldrig_devices.pam.ports.memory import Memory


class MemoryRegisters:
    """Implements `Registers` of fieldrig_bus.modbus.server."""

    def __init__(self, memory: Memory) -> None:
        self._memory = memory

    def read(self, address: int, quantity: int) -> bytes:
        try:
            return struct.pack(f">{quantity}H", *self._memory.read(address, quantity))
        except IndexError as cause:
            raise ModbusError(ILLEGAL_DATA_ADDRESS) from cause

    def write(self, address: int, data: bytes) -> None:
        try:
            self._memory.write(address, struct.unpack(f">{len(data) // 2}H", data))
        except IndexError as cause:
            raise ModbusError(ILLEGAL_DATA_ADDRESS) from cause


class NoBits:
    """Implements `Bits`: the memory has words only."""

    def read(self, address: int, quantity: int) -> bytes:
        raise ModbusError(ILLEGAL_DATA_ADDRESS)

    def write(self, address: int, quantity: int, packed: bytes) -> None:
        raise ModbusError(ILLEGAL_DATA_ADDRESS)


class MemoryUnit:
    """Implements `DataModel` for one memory."""

    def __init__(self, memory: Memory) -> None:
        self.holding_registers = self.input_registers = MemoryRegisters(memory)
        self.coils = self.discrete_inputs = NoBits()

    def fifo(self, address: int) -> list[int]:
        raise ModbusError(ILLEGAL_DATA_ADDRESS)

    def exception_status(self) -> int:
        return 0
