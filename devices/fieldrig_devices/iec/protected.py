"""The variables of a program that take no value from outside: it would be lost in the next cycle, or is not allowed.

These are the pins that the program sets in any instance, the variables that each cycle overwrites before it uses them
(`written.py`), and the outputs of function blocks, which only their block may write (IEC 61131-3:2013, 6.6.3.2).  What
is at an address of %I belongs to its terminal.
"""

import re
from collections.abc import Iterator
from typing import Final

from fieldrig_devices.iec.flow import DATA
from fieldrig_devices.iec.layout import members, variable_size
from fieldrig_devices.iec.program import Located
from fieldrig_devices.iec.symbols import Symbol, Symbols
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import BlockType
from fieldrig_devices.iec.written import Written, overlap

_END_OF_PART: Final = re.compile(r"[.\[]")


class Protected:
    """The variables of one program that others may not set."""

    def __init__(self, written: Written, symbols: Symbols) -> None:
        self._written, self._symbols = written, symbols

    def has(self, path: str) -> bool:
        """Return whether the variable with this path is one of them; False if there is none."""
        symbol = self._symbols.find(path)
        return symbol is not None and symbol.is_value and self._is_protected(symbol)

    def _is_protected(self, symbol: Symbol) -> bool:
        if symbol.location is not None:
            return self._is_located(symbol.location)
        start, size = symbol.steps[-1], symbol.type.size
        if len(symbol.steps) == 1 and overlap(self._written.spans.get(DATA, ()), start, start + size):
            return True
        return any(self._is_of_block(block, start - block.steps[-1], size) for block in self._around(symbol))

    def _is_located(self, place: Located) -> bool:
        first, count = place.byte * 8 + max(place.bit, 0), 1 if place.bit >= 0 else 8 * place.type.size
        if place.area == "Q":
            return any(divmod(bit, 8) in self._written.bits for bit in range(first, first + count))
        return place.area == "I" or overlap(self._written.spans.get(place.area, ()), first, first + count)

    def _around(self, symbol: Symbol) -> Iterator[Symbol]:
        """Yield the instances that a variable is in, unless a reference leads on from them."""
        for end in _END_OF_PART.finditer(symbol.path):
            around = self._symbols.find(symbol.path[: end.start()])
            if around is not None and around.steps[:-1] == symbol.steps[:-1]:
                yield around

    def _is_of_block(self, instance: Symbol, offset: int, size: int) -> bool:
        """Return whether a block writes these cells of each of its instances."""
        kind = instance.type
        if not isinstance(kind, BlockType) or kind.pou is None or kind.pou.kind is PouKind.PROGRAM:
            return False
        if overlap(self._written.blocks.get(kind.pou.name.casefold(), ()), offset, offset + size):
            return True
        variable = next((one for one in members(kind) if one.offset <= offset < one.offset + variable_size(one)), None)
        return variable is not None and variable.section is Section.OUTPUT
