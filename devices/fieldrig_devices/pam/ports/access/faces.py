"""All ways to the memory of one PAM, over the links that it has."""

import struct
from collections.abc import Sequence

from pydantic import Field

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, ModbusError
from fieldrig_bus.modbus.message import ModbusMessage
from fieldrig_bus.modbus.server import ModbusServer
from fieldrig_bus.tcp.message import TcpMessage
from fieldrig_devices.connections.face import TcpFace
from fieldrig_devices.modbus.port import ModbusPort, PortSettings
from fieldrig_devices.pam.ports.access.s7 import serving_s7
from fieldrig_devices.pam.ports.access.word_service import serving_words
from fieldrig_devices.pam.ports.memory import ByteOrder, Memory


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
    """The memory as Modbus registers: register n is word n, as a holding register and as an input register.

    Implements `DataModel`.
    """

    def __init__(self, memory: Memory) -> None:
        self.holding_registers = self.input_registers = MemoryRegisters(memory)
        self.coils = self.discrete_inputs = NoBits()

    def fifo(self, address: int) -> list[int]:
        raise ModbusError(ILLEGAL_DATA_ADDRESS)

    def exception_status(self) -> int:
        return 0


class AccessSettings(PortSettings):
    """How masters outside reach the memory."""

    turnaround_ms: float = Field(
        default=0.0, ge=0, le=60_000, description="time from a Modbus request to its response; 0: immediately"
    )
    data_block: int = Field(default=1, ge=1, le=0xFFFF, description="number of the data block for S7 clients")


class MemoryFaces:
    """The services `dualport` (words) and `s7` (data block) of a `tcp.server` bus, and registers on Modbus buses."""

    def __init__(
        self,
        clock: Clock,
        memory: Memory,
        order: ByteOrder,
        settings: AccessSettings,
        modbus: Sequence[Link[ModbusMessage]] = (),
        tcp: Link[TcpMessage] | None = None,
    ) -> None:
        unit = MemoryUnit(memory)
        for link in modbus:
            port = ModbusPort(clock, link, {settings.unit_id: ModbusServer(unit)}, settings.turnaround_ns)
            link.on_receive(port.on_message, [settings.unit_id])
        services = {"dualport": serving_words(memory), "s7": serving_s7(memory, settings.data_block, order)}
        self._tcp = None if tcp is None else TcpFace(tcp, services)

    def open(self) -> None:
        """Serve from now on."""
        if self._tcp is not None:
            self._tcp.open()

    def close(self) -> None:
        if self._tcp is not None:
            self._tcp.close()
