"""The values of Modbus messages, one by one: registers and bits by the names of their table, exceptions.

Source: Modbus application protocol V1.1b3, chapters 6 and 7.
"""

import struct
from collections.abc import Sequence
from typing import Final

from fieldrig.traces.parts import Part
from fieldrig_bus.modbus.codec import EXCEPTIONS, FUNCTIONS
from fieldrig_devices.modbus.function_words import request_of, response_of
from fieldrig_devices.registers.described import RegisterNames
from fieldrig_devices.registers.named import NamedRegisters

SPACES: Final = {
    1: "coils",
    2: "discrete_inputs",
    3: "holding_registers",
    4: "input_registers",
    23: "holding_registers",
}
OF_RANGES: Final = frozenset((*SPACES, 5, 6, 15, 16))
"""Functions with an address, and a number or a value after it."""
BITS: Final = (1, 2)
EXCEPTION: Final = 0x80
_RANGE: Final = struct.Struct(">HH")
HEAD: Final = 1 + _RANGE.size


def request_parts(registers: RegisterNames, pdu: bytes) -> Sequence[Part]:
    """Return the function of a request with its addresses, and the values that it writes."""
    function = pdu[0]
    name = FUNCTIONS.get(function, f"function {function}")
    if len(pdu) < HEAD or function not in OF_RANGES:
        return Part("function", "", function, name), Part("data", "", pdu.hex(), request_of(pdu))
    address, count = _RANGE.unpack_from(pdu, 1)
    if function == 5:
        return Part("function", "", function, name), *_bits(registers, "coils", address, 1, bytes((count == 0xFF00,)))
    if function == 6:
        return Part("function", "", function, name), *_registers(registers, "holding_registers", address, pdu[3:])
    place = Part("function", "", pdu[:HEAD].hex(), f"{name} from {address}, {count} of them")
    if function == 15:
        return place, *_bits(registers, "coils", address, count, pdu[HEAD + 1 :])
    if function == 16:
        return place, *_registers(registers, "holding_registers", address, pdu[HEAD + 1 :])
    rest = pdu[HEAD:]
    return (place, Part("data", "", rest.hex(), rest.hex(" ").upper())) if rest else (place,)


def response_parts(registers: RegisterNames, pdu: bytes, request: bytes) -> Sequence[Part]:
    """Return the values of a response, or its exception."""
    function = pdu[0] & ~EXCEPTION
    if pdu[0] & EXCEPTION:
        code = pdu[1] if len(pdu) > 1 else 0
        return (Part("exception", "", code, f"{code:02X}h {EXCEPTIONS.get(code, '')}".rstrip()),)
    if len(request) < HEAD or request[0] != function or function not in SPACES:
        return (Part("data", "", pdu.hex(), response_of(pdu)),)
    address, count = _RANGE.unpack_from(request, 1)
    if function in BITS:
        return _bits(registers, SPACES[function], address, count, pdu[2:])
    return _registers(registers, SPACES[function], address, pdu[2:])


def _registers(registers: RegisterNames, space: str, address: int, data: bytes) -> Sequence[Part]:
    if isinstance(registers, NamedRegisters):
        return registers.parts(space, address, data)
    return [
        Part(
            registers.names(space, address + at // 2, 1),
            "",
            int.from_bytes(data[at : at + 2]),
            f"{data[at : at + 2].hex().upper()}h",
        )
        for at in range(0, len(data) - 1, 2)
    ]


def _bits(registers: RegisterNames, space: str, address: int, count: int, data: bytes) -> Sequence[Part]:
    number = int.from_bytes(data, "little")
    return [
        Part(registers.names(space, address + at, 1), "", number >> at & 1, "on" if number >> at & 1 else "off")
        for at in range(min(count, 8 * len(data)))
    ]
