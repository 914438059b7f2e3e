"""Modbus messages by name: function, unit, and the registers and bits by the names of the register table.

Source: Modbus application protocol V1.1b3, chapter 6.  A response with registers has no addresses, so it is named by
its request, which has the same exchange.
"""

import struct
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

from fieldrig.bus import Bus
from fieldrig.traces.names import Member, Named, Namer
from fieldrig.traces.parts import Parts
from fieldrig_bus.modbus.codec import EXCEPTIONS, FUNCTIONS, show
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.modbus.function_words import request_of, response_of
from fieldrig_devices.modbus.parts import request_parts, response_parts
from fieldrig_devices.registers.described import HasRegisterNames, HasTables, RegisterNames
from fieldrig_devices.registers.named import NamedRegisters
from fieldrig_devices.registers.table import Table, load_table

READ_SPACES: Final = {1: "coils", 2: "discrete_inputs", 3: "holding_registers", 4: "input_registers"}
BIT_READS: Final = (1, 2)
WRITE_COIL, WRITE_REGISTER, WRITE_COILS, WRITE_REGISTERS, MASK_WRITE, READ_WRITE = 5, 6, 15, 16, 22, 23
OF_REGISTERS: Final = frozenset(
    (*READ_SPACES, WRITE_COIL, WRITE_REGISTER, WRITE_COILS, WRITE_REGISTERS, MASK_WRITE, READ_WRITE)
)
EXCEPTION: Final = 0x80
MOST_OPEN: Final = 256
"""Requests without a response that are remembered."""
_RANGE: Final = struct.Struct(">HH")
EMPTY: Final = NamedRegisters(Table())


class KnownUnit(NamedTuple):
    """A unit of the bus: the name of its device, and its registers."""

    name: str
    registers: RegisterNames


class ModbusNames:
    """Names the messages of one bus."""

    def __init__(self, units: Mapping[int, KnownUnit]) -> None:
        """`units` are those that the rig knows, by unit id; the registers of others are named by their addresses."""
        self._units = units
        self._open: OrderedDict[tuple[int, int], bytes] = OrderedDict()
        """The PDUs of requests without a response, by unit and exchange."""

    def __call__(self, message: Any, sender: str = "") -> Named:
        if not isinstance(message, ModbusRequest | ModbusResponse):
            return Named("", "", show(message))
        unit = self._unit_of(message)
        function = FUNCTIONS.get(message.pdu[0] & ~EXCEPTION, f"function {message.pdu[0] & ~EXCEPTION}")
        if isinstance(message, ModbusRequest):
            self._remember(message)
            return Named(function, unit.name, request_words(unit.registers, message.pdu))
        request = self._open.pop(message.request, None)
        if message.pdu[0] & EXCEPTION:
            code = message.pdu[1] if len(message.pdu) > 1 else 0
            return Named(f"{function}: exception", unit.name, f"{code:02X}h {EXCEPTIONS.get(code, '')}".rstrip())
        return Named(f"{function}: response", unit.name, response_words(unit.registers, message.pdu, request))

    def unit(self, unit_id: int) -> KnownUnit:
        """Return what is known of a unit; one that is not known has a name too, and no registers."""
        return self._units.get(unit_id) or KnownUnit(f"unit {unit_id}", EMPTY)

    @property
    def units(self) -> Mapping[int, KnownUnit]:
        """The units that are known, by unit id."""
        return self._units

    def parts(self, message: Any, request: bytes = b"") -> Parts | None:
        """Return the registers and bits of a message; those of a response are found by its request."""
        if not isinstance(message, ModbusRequest | ModbusResponse):
            return None
        unit = self._unit_of(message)
        function = FUNCTIONS.get(message.pdu[0] & ~EXCEPTION, f"function {message.pdu[0] & ~EXCEPTION}")
        if isinstance(message, ModbusRequest):
            return Parts(unit.name, function, request_parts(unit.registers, message.pdu))
        return Parts(unit.name, f"{function}: response", response_parts(unit.registers, message.pdu, request))

    def _unit_of(self, message: ModbusRequest | ModbusResponse) -> KnownUnit:
        return self.unit(message.unit if isinstance(message, ModbusRequest) else message.request.unit)

    def _remember(self, request: ModbusRequest) -> None:
        self._open[request.unit, request.exchange] = request.pdu
        if len(self._open) > MOST_OPEN:
            self._open.popitem(last=False)


def request_words(registers: RegisterNames, pdu: bytes) -> str:
    """Return what a request reads, or what it writes with the values."""
    function, data = pdu[0], pdu[1:]
    try:
        if function in READ_SPACES:
            return registers.names(READ_SPACES[function], *_RANGE.unpack(data))
        match function:
            case 5:
                address, value = _RANGE.unpack(data)
                return registers.bits("coils", address, 1, bytes((value == 0xFF00,)))
            case 6:
                return registers.registers("holding_registers", _RANGE.unpack(data)[0], data[2:])
            case 15:
                address, count = _RANGE.unpack_from(data)
                return registers.bits("coils", address, count, data[5:])
            case 16:
                return registers.registers("holding_registers", _RANGE.unpack_from(data)[0], data[5:])
            case 22:
                address, keep, add = struct.unpack(">HHH", data)
                return f"{registers.names('holding_registers', address, 1)} and {keep:04X}h or {add:04X}h"
            case 23:
                read, write = _RANGE.unpack_from(data), _RANGE.unpack_from(data, 4)
                written = registers.registers("holding_registers", write[0], data[9:])
                return f"write {written}; read {registers.names('holding_registers', *read)}"
    except struct.error:
        pass  # a PDU that is cut short
    return request_of(pdu)


def response_words(registers: RegisterNames, pdu: bytes, request: bytes | None) -> str:
    """Return the values of a response that is no exception, by its request."""
    function, data = pdu[0], pdu[1:]
    if function not in OF_REGISTERS:
        return response_of(pdu)
    if request is None or request[0] != function or len(request) < 1 + _RANGE.size:
        return data.hex(" ").upper()
    address, count = _RANGE.unpack_from(request, 1)
    if function in BIT_READS:
        return registers.bits(READ_SPACES[function], address, count, data[1:])
    if function in READ_SPACES or function == READ_WRITE:
        return registers.registers(READ_SPACES.get(function, "holding_registers"), address, data[1:])
    space = "coils" if function in (WRITE_COIL, WRITE_COILS) else "holding_registers"
    return registers.names(space, address, count if function in (WRITE_COILS, WRITE_REGISTERS) else 1)


def namer(bus: Bus[Any], members: Sequence[Member]) -> Namer:
    """Return the namer of a Modbus bus with these devices."""
    units: dict[int, KnownUnit] = {}
    for member in members:
        settings, name = member.entry.settings, member.entry.name
        for unit in settings.register_tables() if isinstance(settings, HasTables) else ():
            units[unit.unit_id] = KnownUnit(name, NamedRegisters(load_table(unit.table)))
        for named in settings.register_names() if isinstance(settings, HasRegisterNames) else ():
            units[named.unit_id] = KnownUnit(name, named.names)
        for claim in member.claims("unit"):
            if isinstance(claim.value, int):
                units.setdefault(claim.value, KnownUnit(name, EMPTY))
    return ModbusNames(units)
