"""The variables of a controller's program as points, for faces, tools and tests.

A point finds its variable again after a download or an online change.  One whose variable is gone reads as 0, and
refuses to be set.
"""

from collections.abc import Callable, Iterable, Iterator

from fieldrig.device import Point, Value
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.iec.symbols import Symbol
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.iec.types import BlockType

MOST_SHOWN = 2_000
"""Variables among the points; faces find the others too."""


class _Variable:
    """One variable by its path."""

    def __init__(self, present: Callable[[], LoadedProgram | None], path: str) -> None:
        self._present, self._path = present, path
        self._compiled: Compiled | None = None
        self._symbol: Symbol | None = None

    def find(self) -> tuple[LoadedProgram, Symbol] | None:
        """Return the variable in the present program; None if there is no value of this name."""
        program = self._present()
        if program is None:
            return None
        if self._compiled is not program.runtime.compiled:
            self._compiled = program.runtime.compiled
            symbol = program.runtime.symbols.find(self._path)
            self._symbol = symbol if symbol is not None and symbol.is_value else None
        return None if self._symbol is None else (program, self._symbol)

    def read(self) -> Value:
        present = self.find()
        if present is None:
            return 0
        program, symbol = present
        return program.runtime.read(symbol)

    def write(self, value: Value) -> None:
        """Set the variable.  ValueError if it is gone or cannot have this value."""
        present = self.find()
        if present is None:
            raise ValueError(f"the program has no variable {self._path} any more")
        program, symbol = present
        program.runtime.write(symbol, value)


class Variables:
    """The variables of the program that is present."""

    def __init__(self, present: Callable[[], LoadedProgram | None]) -> None:
        self._present = present

    def point(self, path: str) -> Point | None:
        """Return the variable with this path, in any case of letters; None if there is no value of this name."""
        variable = _Variable(self._present, path)
        present = variable.find()
        if present is None:
            return None
        _, symbol = present
        return Point(variable.read, variable.write if symbol.is_writable else None, about=symbol.comment)

    def programs(self) -> list[str]:
        """Return the names of the instances of programs."""
        program = self._present()
        return (
            [] if program is None else [root.path for root in program.runtime.symbols.children() if _is_program(root)]
        )

    def points(self, instances: Iterable[str]) -> Iterator[tuple[str, Point]]:
        """Yield the values of the global variables of the project and of `instances`, up to MOST_SHOWN."""
        program = self._present()
        if program is None:
            return
        symbols, shown = program.runtime.symbols, 0
        roots = [symbol for symbol in symbols.children() if not _is_program(symbol)]
        roots += [instance for name in instances if (instance := symbols.find(name)) is not None]
        for root in roots:
            for symbol in symbols.values(root):
                point = self.point(symbol.path)
                if shown >= MOST_SHOWN or point is None:
                    return
                shown += 1
                yield symbol.path, point


def _is_program(symbol: Symbol) -> bool:
    type = symbol.type
    return isinstance(type, BlockType) and type.pou is not None and type.pou.kind is PouKind.PROGRAM
