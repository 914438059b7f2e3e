"""Multiplexed PDOs: one variable per message, with its address.

Source: CiA 301 7.2.2.4 (destination and source address mode), 7.5.2.39 (object scanner list, 1FA0h), 7.5.2.40 (object
dispatching list, 1FD0h).  Only for an EDS with GroupMessaging=1.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from struct import Struct

from fieldrig_devices.canopen.abort import Abort
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.variable import Variable

SCANNER_LISTS, DISPATCHING_LISTS = (0x1FA0, 0x1FCF), (0x1FD0, 0x1FFF)
SIZE, DATA_SIZE = 8, 4
TO_ADDRESS = 0x80
"""Flag in the first byte: the address is that of the destination, 0 for all nodes; otherwise that of the source."""

MULTIPLEXER = Struct("<BHB")


def encode(address: int, index: int, subindex: int, data: bytes) -> bytes:
    return MULTIPLEXER.pack(address, index, subindex) + data[:DATA_SIZE].ljust(DATA_SIZE, b"\x00")


class Scanner:
    """The variables that a source-addressed TPDO sends, and those of them that have changed since."""

    def __init__(self, dictionary: Dictionary, node_id: int, on_event: Callable[[], None]) -> None:
        self._node_id, self._on_event = node_id, on_event
        self._changed: dict[Variable, None] = {}
        self.watches: list[tuple[Variable, Callable[[], None]]] = [
            (variable, partial(self._on_change, variable)) for variable in _scanned(dictionary)
        ]

    @property
    def is_waiting(self) -> bool:
        return bool(self._changed)

    def take(self) -> bytes:
        """Return the message for the variable that changed first, and remove it."""
        variable = next(iter(self._changed))
        del self._changed[variable]
        return encode(self._node_id, variable.index, variable.subindex, variable.data)

    def _on_change(self, variable: Variable) -> None:
        self._changed.setdefault(variable)
        self._on_event()


def _scanned(dictionary: Dictionary) -> list[Variable]:
    """Return the variables of the scanner lists, whose entries are sub-index, index and count from bit 0 on."""
    scanned: dict[Variable, None] = {}
    for number in _numbers(dictionary, SCANNER_LISTS):
        subindex, index, count = number & 0xFF, number >> 8 & 0xFFFF, number >> 24
        for sub in range(subindex, subindex + max(1, count)):
            variable = dictionary.get(index, sub)
            if variable is not None and variable.is_mappable and variable.access.is_transmitted and _is_short(variable):
                scanned.setdefault(variable)
    return list(scanned)


def dispatched(dictionary: Dictionary, message: bytes) -> Variable | None:
    """Return the variable that a dispatching list assigns to the sender of a source-addressed message, or None."""
    node_id, index, subindex = MULTIPLEXER.unpack_from(message)
    for number in _numbers(dictionary, DISPATCHING_LISTS):
        sender_sub, count = number >> 8 & 0xFF, max(1, number >> 56)
        is_sender = (number & 0xFF, number >> 16 & 0xFFFF) == (node_id, index)
        if is_sender and sender_sub <= subindex < sender_sub + count:
            return dictionary.get(number >> 40 & 0xFFFF, (number >> 32 & 0xFF) + subindex - sender_sub)
    return None


def put(variable: Variable | None, message: bytes) -> bool:
    """Write the data of `message` into `variable`; True if it was accepted."""
    if variable is None or not (variable.is_mappable and variable.access.is_received and _is_short(variable)):
        return False
    try:
        variable.write(message[DATA_SIZE : DATA_SIZE + (variable.type.size or DATA_SIZE)])
    except Abort:
        return False
    return True


def _is_short(variable: Variable) -> bool:
    return (variable.type.size or 0) <= DATA_SIZE


def _numbers(dictionary: Dictionary, lists: Iterable[int]) -> Iterator[int]:
    """Yield the entries in use."""
    first, last = lists
    for index in dictionary.indices(first, last):
        count = dictionary.number(index, 0)
        yield from (entry.number for entry in dictionary.members(index)[:count] if entry.number != 0)
