"""The variables of a program as points, for faces and tools."""

from collections.abc import Iterable, Iterator
from functools import partial

from fieldrig.device import Point
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.iec.symbols import Symbol
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.iec.types import BlockType

MOST_SHOWN = 2_000
"""Variables among the points; faces find the others too."""


def variable_point(program: LoadedProgram, path: str) -> Point | None:
    """Return the variable with this path, in any case of letters; None if there is no value of this name."""
    symbol = program.runtime.symbols.find(path)
    return None if symbol is None or not symbol.is_value else _point(program, symbol)


def variable_points(program: LoadedProgram, instances: Iterable[str]) -> Iterator[tuple[str, Point]]:
    """Yield the values of the global variables of the project and of `instances`, up to MOST_SHOWN."""
    symbols = program.runtime.symbols
    roots = [symbol for symbol in symbols.children() if not _is_program(symbol)]
    roots += [found for name in instances if (found := symbols.find(name)) is not None]
    shown = 0
    for root in roots:
        for symbol in symbols.values(root):
            if shown >= MOST_SHOWN:
                return
            shown += 1
            yield symbol.path, _point(program, symbol)


def _point(program: LoadedProgram, symbol: Symbol) -> Point:
    runtime = program.runtime
    write = partial(runtime.write, symbol) if symbol.is_writable else None
    return Point(partial(runtime.read, symbol), write, about=symbol.comment)


def _is_program(symbol: Symbol) -> bool:
    kind = symbol.type
    return isinstance(kind, BlockType) and kind.pou is not None and kind.pou.kind is PouKind.PROGRAM
