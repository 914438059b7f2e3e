"""MEMCPY, MEMMOVE, MEMSET and MEMCMP: areas of bytes by their addresses.

They are native: a loop of Structured Text over the bytes of a long text would decode and encode it for each of them.

Source: the public descriptions of Tc2_System.  The result of MEMCMP for an address of 0 is that of the controller.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Final

from fieldrig_devices.iec.exceptions import RaisedError
from fieldrig_devices.iec.host import NativeFunction, Results

if TYPE_CHECKING:
    from fieldrig_devices.iec.memory import Memory

COST_NS: Final = 1_000
NO_ADDRESS: Final = 255
"""The result of MEMCMP if an address is 0."""


def _copied(memory: "Memory", target: int, source: int, count: int) -> Results:
    """Copy bytes, also within one area, and return their number; 0 if an address is 0."""
    if not target or not source:
        return (0,)
    if count and not memory.copy_cells(target, source, count):
        memory.check_bytes(target, count)
        memory.put_bytes_at(target, memory.bytes_at(source, count))
    return (count,)


def _set(memory: "Memory", target: int, fill: int, count: int) -> Results:
    """Give bytes one value, and return their number; 0 if the address is 0."""
    if not target:
        return (0,)
    if count:
        memory.check_bytes(target, count)
        memory.put_bytes_at(target, bytes([fill]) * count)
    return (count,)


def _compared(memory: "Memory", one: int, other: int, count: int) -> Results:
    """Return -1 or 1 if the first byte that differs is smaller or larger in the first area, and 0 if none does."""
    if not one or not other:
        return (NO_ADDRESS,)
    if not count:
        return (0,)
    first, second = memory.bytes_at(one, count), memory.bytes_at(other, count)
    return ((first > second) - (first < second),)


def _raised(_: "Memory", number: int) -> Results:
    """Raise the exception with this number, which __CATCH of the program gets."""
    raise RaisedError(number)


_ACTIONS: Final[Mapping[str, Callable[..., Results]]] = {
    "f_raiseexception": _raised,
    "memcpy": _copied,
    "memmove": _copied,
    "memset": _set,
    "memcmp": _compared,
}
NAMES: Final = frozenset(_ACTIONS)
"""The functions, by their names in small letters; each host has them, as they need only the memory of the program."""


def natives(memory: "Memory | None" = None) -> dict[str, NativeFunction]:
    """Return the functions by their names in small letters; without a memory they only have their costs."""
    return {name: NativeFunction(partial(action, memory), COST_NS) for name, action in _ACTIONS.items()}
