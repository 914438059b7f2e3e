"""Requests about values: V, F, I, O, all quantities that can be watched, and parameters."""

import struct
from collections.abc import Sequence
from typing import Final

from fieldrig_devices.arp.card_access import CardAccess
from fieldrig_devices.arp.parameters import PARAMETERS
from fieldrig_devices.arp.user_port import messages, quantities
from fieldrig_devices.arp.user_port.handlers import Handlers
from fieldrig_devices.arp.user_port.messages import (
    MOST_BITS,
    MOST_QUANTITIES,
    MOST_VARIABLES,
    QUANTITY,
    Command,
    Quantity,
    RequestError,
    Status,
)
from fieldrig_devices.arp.user_port.quantities import Kind

RAM, FLASH = 0, 1
"""Numbers of the copies of a parameter."""
_RANGE: Final = struct.Struct("<BHH")  # letter, first number, count
_BITS: Final = struct.Struct("<BHH")  # letter, first number, count; followed by the bits
_FIRST: Final = struct.Struct("<H")  # first number; followed by the values
_PARAMETERS: Final = struct.Struct("<BBBB")  # copy, group, first number, count
_PARAMETER: Final = struct.Struct("<BBBi")  # copy, group, number, raw value


class MemoryRequests:
    def __init__(self, card: CardAccess) -> None:
        self._card = card
        self.handlers: Handlers = {
            Command.READ: self._read,
            Command.READ_MANY: self._read_many,
            Command.WRITE_VARIABLES: self._write_variables,
            Command.WRITE_BITS: self._write_bits,
            Command.READ_PARAMETERS: self._read_parameters,
            Command.WRITE_PARAMETER: self._write_parameter,
        }

    def _read(self, data: bytes) -> bytes:
        kind, first, count = _RANGE.unpack(data)
        most = MOST_VARIABLES if kind == Kind.VARIABLE else MOST_BITS
        cells = _slice(self._card, kind, first, count, most)
        return messages.packed_values(cells) if kind == Kind.VARIABLE else messages.packed_bits(cells)

    def _read_many(self, data: bytes) -> bytes:
        wanted = [Quantity(*fields) for fields in QUANTITY.iter_unpack(data)]
        if not 1 <= len(wanted) <= MOST_QUANTITIES:
            raise RequestError(Status.LENGTH)
        return messages.packed_values(quantities.reader(self._card, quantity)() for quantity in wanted)

    def _write_variables(self, data: bytes) -> bytes:
        (first,), values = _FIRST.unpack_from(data), messages.values_in(data[_FIRST.size :])
        _slice(self._card, Kind.VARIABLE, first, len(values), MOST_VARIABLES)
        if not self._card.set_variables(first, values):
            raise RequestError(Status.REFUSED, f"the variables from V{first} on cannot be written")
        return b""

    def _write_bits(self, data: bytes) -> bytes:
        """Write all bits or none: if one is refused, those written before it get their old values back."""
        kind, first, count = _BITS.unpack_from(data)
        octets = data[_BITS.size :]
        before = _slice(self._card, kind, first, count, MOST_BITS)
        if len(octets) != (count + 7) // 8:
            raise RequestError(Status.LENGTH)
        writers = {Kind.FLAG: self._card.set_flag, Kind.OUTPUT: self._card.set_output}
        write = writers.get(kind)
        if write is None:
            raise RequestError(Status.REFUSED, "only F and O can be written as bits")
        for number, bit in enumerate(messages.bits_in(octets, count), first):
            if not write(number, bit):
                for written, old in zip(range(first, number), before, strict=False):
                    write(written, old)
                raise RequestError(Status.REFUSED, f"{chr(kind)}{number} cannot be written{_why(kind)}")
        return b""

    def _read_parameters(self, data: bytes) -> bytes:
        copy, group, first, count = _PARAMETERS.unpack(data)
        _check_place(copy, group)
        table = (self._card.parameters.ram, self._card.parameters.flash)[copy][group]
        if not 1 <= first <= first + count - 1 < len(table):
            raise RequestError(Status.RANGE, f"expected parameters of group {group} from 1 to {len(table) - 1}")
        return messages.packed_values(table[first : first + count])

    def _write_parameter(self, data: bytes) -> bytes:
        copy, group, number, raw = _PARAMETER.unpack(data)
        _check_place(copy, group)
        if not self._card.parameters.takes(group, number, raw):
            raise RequestError(Status.RANGE, f"parameter {number} of group {group} cannot be {raw} / 1000")
        write = (self._card.set_parameter, self._card.save_parameter)[copy]
        if not write(group, number, raw):
            raise RequestError(Status.REFUSED, "the parameter cannot be written now")
        return b""


def _slice(card: CardAccess, kind: int, first: int, count: int, most: int) -> Sequence[int]:
    """Elements of one table.  Raises RequestError if any of them does not exist."""
    table = quantities.table(card, kind)
    if not 1 <= count <= most:
        raise RequestError(Status.LENGTH, f"expected 1 to {most} elements")
    present = quantities.NUMBERS[kind]
    if any(number not in present for number in range(first, first + count)):
        raise RequestError(Status.RANGE, f"there is no {chr(kind)}{first} to {chr(kind)}{first + count - 1}")
    return table[first : first + count]


def _why(kind: int) -> str:
    return ": only the card writes it" if kind == Kind.FLAG else " while the card holds its outputs at 0"


def _check_place(copy: int, group: int) -> None:
    if copy not in (RAM, FLASH) or group >= len(PARAMETERS):
        raise RequestError(Status.RANGE, "expected copy 0 (RAM) or 1 (flash), and group 0 (general), 1 or 2 (axes)")
