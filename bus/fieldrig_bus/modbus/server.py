"""The Modbus application protocol: it turns a request into its response, over any data model.

Source: Modbus application protocol V1.1b3, chapter 6 (the state diagram of each function decides which exception comes
first: function, then quantity or value, then address, then failure) and chapter 7.  It works on bytes and creates no
objects per request, which makes it much faster than the server of pymodbus (bench/modbus.py).

Left out: CANopen over encapsulated transport (43/13), which is answered as an unknown function (01), and so are file
records (20, 21) where there are no files.  Functions 7, 8 and 17 belong to serial lines; they are answered on TCP as
well, as most devices do, unless `serial_functions_on_tcp` is False.  The event counter and log (11, 12) are answered on
serial lines only: without a line there are no events to log.
"""

import struct
from collections.abc import Callable, Mapping
from typing import Final, Protocol

from fieldrig_bus.modbus import file_records
from fieldrig_bus.modbus.diagnostics import Diagnostics
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_VALUE, ILLEGAL_FUNCTION, ModbusError
from fieldrig_bus.modbus.identification import Identification, ServerId
from fieldrig_bus.modbus.message import BROADCAST, ModbusRequest

MOST_BITS_READ, MOST_BITS_WRITTEN = 2000, 1968
MOST_REGISTERS_READ, MOST_REGISTERS_WRITTEN, MOST_WRITTEN_WITH_READ = 125, 123, 121
MOST_IN_FIFO = 31

BROADCAST_FUNCTIONS: Final = frozenset({5, 6, 15, 16, 22})
"""Functions that may be broadcast, which must be writes (Modbus over serial line V1.02, 2.1)."""

SERIAL_FUNCTIONS: Final = frozenset({7, 8, 17})
LINE_FUNCTIONS: Final = frozenset({11, 12})

Functions = dict[int, Callable[[bytes], bytes | None]]

_TWO: Final = struct.Struct(">HH")
_unpack_two: Callable[[bytes, int], tuple[int, int]] = _TWO.unpack_from
_pack_two = _TWO.pack


class Bits(Protocol):
    """Coils or discrete inputs.  Both methods raise ModbusError: 02 for an address out of range, 04 on failure."""

    def read(self, address: int, quantity: int) -> bytes:
        """Read bits, packed eight to a byte with the first in the lowest bit; unused bits of the last byte are 0."""

    def write(self, address: int, quantity: int, packed: bytes) -> None:
        """Write bits, packed as in `read`: all of them, or none when it raises."""


class Registers(Protocol):
    """Holding or input registers, big endian as on the wire.  They raise ModbusError as `Bits` does."""

    def read(self, address: int, quantity: int) -> bytes: ...

    def write(self, address: int, data: bytes) -> None:
        """Write registers: all of them, or none when it raises."""


class DataModel(Protocol):
    """The data model of one unit (chapter 4.3)."""

    @property
    def coils(self) -> Bits: ...

    @property
    def discrete_inputs(self) -> Bits: ...

    @property
    def holding_registers(self) -> Registers: ...

    @property
    def input_registers(self) -> Registers: ...

    def fifo(self, address: int) -> list[int]:
        """The contents of the queue with this pointer address.  ModbusError 02 if there is none."""

    def exception_status(self) -> int:
        """The exception status, eight bits (function 7)."""


class ModbusServer:
    """One unit at one port: it answers requests there, with the counters of that port."""

    def __init__(
        self,
        data: DataModel,
        identification: Identification | None = None,
        server_id: ServerId | None = None,
        serial_functions_on_tcp: bool = True,
        files: Mapping[int, file_records.File] | None = None,
    ) -> None:
        """`files` are those of functions 20 and 21, by their numbers from 1."""
        self._data = data
        self._server_id = server_id or ServerId()
        self.diagnostics = Diagnostics()
        self._functions: Functions = {
            0x01: _bits_reader(1, data.coils),
            0x02: _bits_reader(2, data.discrete_inputs),
            0x03: _registers_reader(3, data.holding_registers),
            0x04: _registers_reader(4, data.input_registers),
            0x05: self._write_coil,
            0x06: self._write_register,
            0x07: self._exception_status,
            0x08: self.diagnostics.answer,
            0x0B: self._event_counter,
            0x0C: self._event_log,
            0x0F: self._write_coils,
            0x10: self._write_registers,
            0x11: self._report_server_id,
            0x16: self._mask_write,
            0x17: self._read_write,
            0x18: self._read_fifo,
            0x2B: (identification or Identification()).answer,
        }
        if files:
            self._functions |= {0x14: file_records.reader(files), 0x15: file_records.writer(files)}
        left_out = LINE_FUNCTIONS if serial_functions_on_tcp else SERIAL_FUNCTIONS | LINE_FUNCTIONS
        self._functions_on_tcp = {code: handler for code, handler in self._functions.items() if code not in left_out}

    def answer(self, request: ModbusRequest) -> bytes | None:
        """The response PDU; None where there is no response (broadcast, listen only mode)."""
        diagnostics, pdu, line = self.diagnostics, request.pdu, request.line
        diagnostics.server_messages += 1
        diagnostics.line = line
        if line is None:  # the most common case, without a further call
            handler = self._functions_on_tcp.get(pdu[0], _not_there)
            try:
                return handler(pdu)
            except ModbusError as error:
                return self._exception(pdu, error)
        diagnostics.receive(request.unit == BROADCAST, line)
        if request.unit == BROADCAST:
            diagnostics.no_responses += 1
            if pdu[0] in BROADCAST_FUNCTIONS and not diagnostics.is_listening_only:
                self._respond(pdu)
            return None
        if diagnostics.is_listening_only:
            diagnostics.hear_in_listen_only(pdu)
            return None
        return self._respond(pdu)

    def _respond(self, pdu: bytes) -> bytes | None:
        try:
            response = self._functions.get(pdu[0], _not_there)(pdu)
        except ModbusError as error:
            response = self._exception(pdu, error)
            self.diagnostics.send(pdu, error.code)
        else:
            self.diagnostics.send(pdu, 0)
        return response

    def _exception(self, pdu: bytes, error: ModbusError) -> bytes:
        self.diagnostics.exception_responses += 1
        return bytes((pdu[0] | 0x80, error.code))

    def _write_coil(self, pdu: bytes) -> bytes:
        address, value = _two_words(pdu)
        if value not in (0x0000, 0xFF00):
            raise ModbusError(ILLEGAL_DATA_VALUE)
        self._data.coils.write(address, 1, b"\x01" if value else b"\x00")
        return pdu

    def _write_register(self, pdu: bytes) -> bytes:
        address, _ = _two_words(pdu)
        self._data.holding_registers.write(address, pdu[3:5])
        return pdu

    def _exception_status(self, pdu: bytes) -> bytes:
        _check(len(pdu) == 1)
        return bytes((0x07, self._data.exception_status() & 0xFF))

    def _event_counter(self, pdu: bytes) -> bytes:
        _check(len(pdu) == 1)
        return b"\x0b" + self.diagnostics.events.counter()

    def _event_log(self, pdu: bytes) -> bytes:
        _check(len(pdu) == 1)
        return b"\x0c" + self.diagnostics.events.log(self.diagnostics.server_messages)

    def _write_coils(self, pdu: bytes) -> bytes:
        _check(len(pdu) >= 6)
        address, quantity = _unpack_two(pdu, 1)
        size = (quantity + 7) // 8
        _check(1 <= quantity <= MOST_BITS_WRITTEN and pdu[5] == size == len(pdu) - 6)
        self._data.coils.write(address, quantity, pdu[6:])
        return pdu[:5]

    def _write_registers(self, pdu: bytes) -> bytes:
        _check(len(pdu) >= 6)
        address, quantity = _unpack_two(pdu, 1)
        _check(1 <= quantity <= MOST_REGISTERS_WRITTEN and pdu[5] == 2 * quantity == len(pdu) - 6)
        self._data.holding_registers.write(address, pdu[6:])
        return pdu[:5]

    def _report_server_id(self, pdu: bytes) -> bytes:
        _check(len(pdu) == 1)
        data = self._server_id.data()
        return bytes((0x11, len(data))) + data

    def _mask_write(self, pdu: bytes) -> bytes:
        _check(len(pdu) == 7)
        address, and_mask = _unpack_two(pdu, 1)
        or_mask = int.from_bytes(pdu[5:7], "big")
        registers = self._data.holding_registers
        present = int.from_bytes(registers.read(address, 1), "big")
        result = present & and_mask | or_mask & ~and_mask  # 6.16
        registers.write(address, result.to_bytes(2, "big"))
        return pdu

    def _read_write(self, pdu: bytes) -> bytes:
        _check(len(pdu) >= 10)
        read_address, read_quantity = _unpack_two(pdu, 1)
        write_address, write_quantity = _unpack_two(pdu, 5)
        _check(1 <= read_quantity <= MOST_REGISTERS_READ and 1 <= write_quantity <= MOST_WRITTEN_WITH_READ)
        _check(pdu[9] == 2 * write_quantity == len(pdu) - 10)
        registers = self._data.holding_registers
        registers.read(read_address, read_quantity)  # both addresses are checked before anything is written
        registers.write(write_address, pdu[10:])
        return bytes((0x17, 2 * read_quantity)) + registers.read(read_address, read_quantity)  # 6.17: write, then read

    def _read_fifo(self, pdu: bytes) -> bytes:
        _check(len(pdu) == 3)
        queue = self._data.fifo(int.from_bytes(pdu[1:3], "big"))
        _check(len(queue) <= MOST_IN_FIFO)  # 6.18: more than 31 is exception 03
        values = struct.pack(f">{len(queue)}H", *queue)
        return b"\x18" + _pack_two(2 + len(values), len(queue)) + values


def _bits_reader(function: int, bits: Bits) -> Callable[[bytes], bytes]:
    heads = {size: bytes((function, size)) for size in range(1, 251)}
    read = bits.read

    def answer(pdu: bytes) -> bytes:
        if len(pdu) != 5:
            raise ModbusError(ILLEGAL_DATA_VALUE)
        address, quantity = _unpack_two(pdu, 1)
        if not 1 <= quantity <= MOST_BITS_READ:
            raise ModbusError(ILLEGAL_DATA_VALUE)
        return heads[(quantity + 7) >> 3] + read(address, quantity)

    return answer


def _registers_reader(function: int, registers: Registers) -> Callable[[bytes], bytes]:
    heads = [bytes((function, 2 * quantity)) for quantity in range(MOST_REGISTERS_READ + 1)]
    read = registers.read

    def answer(pdu: bytes) -> bytes:
        if len(pdu) != 5:
            raise ModbusError(ILLEGAL_DATA_VALUE)
        address, quantity = _unpack_two(pdu, 1)
        if not 1 <= quantity <= MOST_REGISTERS_READ:
            raise ModbusError(ILLEGAL_DATA_VALUE)
        return heads[quantity] + read(address, quantity)

    return answer


def _not_there(pdu: bytes) -> bytes | None:
    raise ModbusError(ILLEGAL_FUNCTION)


def _two_words(pdu: bytes) -> tuple[int, int]:
    _check(len(pdu) == 5)
    return _unpack_two(pdu, 1)


def _check(is_right: bool) -> None:
    """Raise ModbusError 03 for a wrong length: the implied length is incorrect (chapter 7, code 03)."""
    if not is_right:
        raise ModbusError(ILLEGAL_DATA_VALUE)
