"""Addresses of a Smart-IO node: M PP for inputs and outputs, module times 100 plus position (Appendix E).

IN 0 and OUT 0 of module 1 have the address 101, IN 11 of module 16 has 1612.  Keys and LEDs count from 1 (G-05), the
analog output and the display have the address 1.
"""

from collections.abc import Iterator
from typing import Final

MODULES: Final = 16
POSITIONS: Final = 12
GROUP: Final = 4
"""Outputs that share the detection of short circuits (12.1.1.6)."""


def place_of(address: int) -> tuple[int, int]:
    """Return the module, from 1, and the position, from 1, of an address that need not exist."""
    return divmod(address, 100)


def exists(address: int) -> bool:
    module, position = place_of(address)
    return 1 <= module <= MODULES and 1 <= position <= POSITIONS


def addresses_of(module: int) -> Iterator[int]:
    """Yield the addresses of a module, in their order."""
    yield from range(100 * module + 1, 100 * module + POSITIONS + 1)


def group_of(address: int) -> int:
    """Return the group of an output: 1 for OUT 1 to 4, 2 for OUT 5 to 8, 3 for OUT 9 to 12."""
    return (place_of(address)[1] - 1) // GROUP + 1
