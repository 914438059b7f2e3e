"""The variables of a program by name: for OPC UA, watch windows, forcing, retained data, and the symbol list.

A path is as an engineer writes it, `PLC_PRG.belt.axis[3].pos`, in any case of letters; the elements of an array of two
dimensions are `[1,2]` or `[1][2]`.  Global variables and programs are the roots.
"""

import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Final

from fieldrig_devices.iec.layout import members, storage
from fieldrig_devices.iec.program import CLASS, Located, Program, Variable
from fieldrig_devices.iec.types import ArrayType, BlockType, StructType, Type

_PART: Final = re.compile(r"\.?([A-Za-z_]\w*)|\[\s*(-?\d+(?:\s*,\s*-?\d+)*)\s*\]")


@dataclass(frozen=True, slots=True)
class Symbol:
    path: str
    name: str
    type: Type
    comment: str = ""
    is_writable: bool = True
    is_retain: bool = False
    steps: tuple[int, ...] = (0,)
    """Its address; with more than one number, each but the last leads to a cell with an address to add the next to."""
    location: Located | None = None
    """The address of a variable with AT; it has no cell."""
    is_in_union: bool = False
    """True if its cells may have values of another type."""
    bit: int = -1
    """The number of a BIT in the byte at its address; -1 for other variables."""

    @property
    def is_value(self) -> bool:
        """True if it has a value of its own, and no children."""
        return storage(self.type) is not None


class Symbols:
    def __init__(self, program: Program, files: Collection[str]) -> None:
        """`files` are those of the project; variables of libraries are found by their names only."""
        self._key = program.dialect.key
        self._known = {name: _of_variable(variable) for name, variable in program.globals.items()}
        for name, pou in (pair for task in program.tasks for pair in task.instances.items()):
            if pou.instance is not None:
                self._known.setdefault(name, self._known[self._key(pou.instance.name)])
        self._static = {name: symbol for name, symbol in self._known.items() if "." in name}
        """The variables of VAR_STAT, whose names begin with that of their unit."""
        self._roots = [self._known[name] for name, variable in program.globals.items() if variable.file in files]

    def children(self, path: str = "") -> list[Symbol]:
        """Return the parts of a symbol, the roots for an empty path, and nothing for an unknown one.

        Variables that no source text declares, such as an accumulator of IL, are left out.
        """
        if not path:
            return list(self._roots)
        symbol = self.find(path)
        return [part for part in parts(symbol) if part.name[:1] != "$"] if symbol is not None else []

    def find(self, path: str) -> Symbol | None:
        for name, static in self._static.items():
            if path.lower().startswith(name) and path[len(name) : len(name) + 1] in ("", ".", "["):
                return below(static, path[len(name) :], self._key)
        first = _PART.match(path)
        symbol = self._known.get(self._key(first[1] or "")) if first is not None and path[:1] != "." else None
        return below(symbol, path[first.end() :], self._key) if symbol is not None and first is not None else None

    def within(self, variable: Variable, path: str) -> Symbol | None:
        """Return what a path such as `.axis[3].pos` means in a global variable, also in one that no name finds."""
        return below(_of_variable(variable), path, self._key)

    def closest(self, path: str) -> str:
        """Return the path that a wrong one may mean: the same in a program, or one that is most alike; or nothing."""
        inside = [symbol.path for root in self._roots if (symbol := self.find(f"{root.path}.{path}")) is not None]
        if inside:
            return inside[0]
        known = [root.path for root in self._roots]
        known += [part.path for root in self._roots for part in self.children(root.path)]
        last = {name.rpartition(".")[2].casefold(): name for name in reversed(known)}
        whole = {name.casefold(): name for name in known}
        for names in (whole, last):
            for name in get_close_matches(path.casefold(), names, n=1):
                return names[name]
        return ""

    def values(self, symbol: Symbol | None = None) -> Iterator[Symbol]:
        """Yield all symbols that have a value of their own, below one symbol or of the whole program."""
        if symbol is not None and symbol.is_value:
            yield symbol
            return
        for part in parts(symbol) if symbol is not None else self.children():
            yield from self.values(part)


def below(symbol: Symbol, path: str, key: Callable[[str], str]) -> Symbol | None:
    """Return what a path such as `.axis[3].pos` means behind a symbol; the symbol itself for an empty path.

    `key` is that of the dialect, which says what a name is found by.
    """
    inner: Symbol | None = symbol
    at, method = 0, ""
    for match in _PART.finditer(path):
        if match.start() != at or inner is None:
            return None
        at = match.end()
        if match[1]:
            name = f"{method}{key(match[1])}"
            part = _part(inner, name)
            method = f"{name}." if part is None and not method else ""
            inner = part if part is not None or not method else inner
        else:
            for index in match[2].split(","):
                inner = _element(inner, int(index)) if inner is not None else None
    return inner if at == len(path) and not method else None


def parts(symbol: Symbol) -> list[Symbol]:
    kind = symbol.type
    if isinstance(kind, ArrayType):
        elements = (_element(symbol, index) for index in range(kind.low, kind.high + 1))
        return [symbol for symbol in elements if symbol is not None]
    if isinstance(kind, StructType):
        return [_part(symbol, name) or symbol for name in kind.fields]
    if isinstance(kind, BlockType) and kind.pou is not None:
        names = (name for name, one in kind.pou.variables.items() if name != CLASS and not _leads_on(symbol, one))
        return [part for name in names if (part := _part(symbol, name)) is not None]
    return []


def _leads_on(symbol: Symbol, variable: Variable) -> bool:
    """True for what may have instances, by reference, in an instance by reference: such a way may go on without end.

    `find` goes it as far as a path says.
    """
    kind = variable.type
    while isinstance(kind, ArrayType):
        kind = kind.element
    return variable.is_reference and len(symbol.steps) > 1 and isinstance(kind, StructType | BlockType)


def _of_variable(variable: Variable) -> Symbol:
    return Symbol(
        variable.name,
        variable.name,
        variable.type,
        variable.comment,
        not variable.is_constant,
        variable.is_retain,
        (variable.offset,),
        variable.location,
    )


def _part(symbol: Symbol, name: str) -> Symbol | None:
    kind = symbol.type
    if isinstance(kind, StructType):
        field = kind.fields.get(name)
        if field is None:
            return None
        path = f"{symbol.path}.{field.name}"
        part = replace(symbol, path=path, name=field.name, type=field.type, comment=field.comment)
        part = replace(part, is_in_union=symbol.is_in_union or kind.is_union, bit=field.bit)
        return _moved(part, field.offset)
    if not isinstance(kind, BlockType) or kind.pou is None:
        return None
    variable = kind.pou.variables.get(name)
    if variable is None or (variable.location is None and variable not in members(kind)):
        return None
    own = _of_variable(variable)
    steps = (*symbol.steps[:-1], symbol.steps[-1] + max(variable.offset, 0))
    return replace(
        own,
        path=f"{symbol.path}.{variable.name}",
        is_writable=own.is_writable and symbol.is_writable,
        is_retain=own.is_retain or symbol.is_retain,
        steps=(*steps, 0) if variable.is_reference else steps,
    )


def _element(symbol: Symbol, index: int) -> Symbol | None:
    kind = symbol.type
    if not isinstance(kind, ArrayType) or not kind.low <= index <= kind.high:
        return None
    inner = symbol.path.endswith("]") and not symbol.name.isidentifier()
    path = f"{symbol.path[:-1]},{index}]" if inner else f"{symbol.path}[{index}]"
    part = replace(symbol, path=path, name=f"[{path.rpartition('[')[2]}", type=kind.element)
    return _moved(part, (index - kind.low) * kind.element.size)


def _moved(symbol: Symbol, offset: int) -> Symbol:
    if symbol.location is not None:
        return replace(symbol, location=replace(symbol.location, byte=symbol.location.byte + offset))
    return replace(symbol, steps=(*symbol.steps[:-1], symbol.steps[-1] + offset))
