"""The variables of an IEC 61131-3 program as nodes: `PLC_PRG.belt.position`, `GVL_axes[3].speed`.

Programs, instances and structures are objects with their parts below them.  An array of values is one variable, with
its elements below it as variables of their own.  Paths are those of `iec.symbols`, so case does not matter, and the
NodeId has the case of the declaration.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Final, overload

from fieldrig.device import Value
from fieldrig_bus.opcua.message import LONGEST_PATH, MOST_ELEMENTS, AnyValue, Kind, Node
from fieldrig_devices.iec.elementary import LONG_TIMES, LONGER, SHORT_TIMES, Elementary
from fieldrig_devices.iec.runtime import MOST_FORCED, Runtime
from fieldrig_devices.iec.symbols import Symbol, Symbols
from fieldrig_devices.iec.types import ArrayType, EnumType, ObjectType, PointerType, StringType, SubrangeType, Type
from fieldrig_devices.iec.values import checked
from fieldrig_devices.opcua.tree import UnknownNodeError

_LONGEST_INDEX: Final = len("[-2147483648]")
_UNITS: Final = {**dict.fromkeys(SHORT_TIMES, "ms"), **dict.fromkeys((*LONGER.values(), *LONG_TIMES), "ns")}


class SymbolsTree:
    def __init__(self, symbols: Symbols, runtime: Runtime) -> None:
        self._symbols, self._runtime = symbols, runtime

    def children(self, path: str) -> Sequence[Node]:
        symbol = self._symbols.find(path) if path else None
        if symbol is not None and isinstance(symbol.type, ArrayType):
            has_room = len(path) + _LONGEST_INDEX <= LONGEST_PATH
            return _Elements(symbol.type, lambda index: self._node(self._element(symbol, index))) if has_room else []
        return [self._node(child) for child in self._symbols.children(path) if len(child.path) <= LONGEST_PATH]

    def find(self, path: str) -> Node | None:
        symbol = self._symbols.find(path) if len(path) <= LONGEST_PATH else None
        return None if symbol is None else self._node(symbol)

    def read(self, path: str) -> AnyValue:
        symbol = self._symbol(path)
        if not isinstance(symbol.type, ArrayType):
            return self._runtime.read(symbol)
        return [self._runtime.read(element) for element in self._elements(symbol, symbol.type)]

    def write(self, path: str, value: AnyValue) -> None:
        for symbol, one in self._each(path, value):
            self._runtime.write(symbol, one)

    def call(self, path: str, arguments: Sequence[AnyValue]) -> Sequence[AnyValue]:
        raise UnknownNodeError(path)

    # ---- forcing

    def check(self, path: str, value: AnyValue) -> None:
        """Raise TypeError or ValueError for a value that the variable cannot have."""
        for symbol, one in self._each(path, value):
            checked(one, symbol)

    def force(self, path: str, value: AnyValue) -> None:
        """Hold a variable, or each element of an array, at a value.  ValueError if that is not possible now."""
        found = self._each(path, value)
        if len(self._runtime.forced.keys() | {symbol.path for symbol, _ in found}) > MOST_FORCED:
            raise ValueError(f"expected at most {MOST_FORCED} forced variables")
        for symbol, one in found:
            self._runtime.force(symbol, one)

    def release(self, path: str) -> None:
        """Release a variable with all that is below it; all variables for an empty path."""
        top = path.lower()
        for known in self._runtime.forced:
            if not top or known.lower() == top or known.lower().startswith((f"{top}.", f"{top}[", f"{top[:-1]},")):
                self._runtime.force(self._runtime.find(known), None)

    def forced(self) -> Sequence[str]:
        """Return the paths of the variables that are forced."""
        return [path for path in self._runtime.forced if len(path) <= LONGEST_PATH]

    # ---- symbols

    def _each(self, path: str, value: AnyValue) -> list[tuple[Symbol, Value]]:
        """Return a variable, or the elements of an array, with their values."""
        symbol = self._symbol(path)
        if isinstance(symbol.type, ArrayType) != isinstance(value, list):
            raise TypeError(f"{path} is {symbol.type}")
        if not isinstance(value, list):
            return [(symbol, value)]
        assert isinstance(symbol.type, ArrayType)
        if len(value) != symbol.type.count:
            raise ValueError(f"expected {symbol.type.count} elements, got {len(value)}")
        return list(zip(self._elements(symbol, symbol.type), value, strict=True))

    def _symbol(self, path: str) -> Symbol:
        symbol = self._symbols.find(path)
        if symbol is None or self._node(symbol).kind is not Kind.VARIABLE:
            raise UnknownNodeError(path)
        return symbol

    def _elements(self, symbol: Symbol, kind: ArrayType) -> Iterator[Symbol]:
        return (self._element(symbol, index) for index in range(kind.low, kind.high + 1))

    def _element(self, symbol: Symbol, index: int) -> Symbol:
        found = self._symbols.find(f"{symbol.path}[{index}]")
        if found is None:
            raise UnknownNodeError(f"{symbol.path}[{index}]")
        return found

    def _node(self, symbol: Symbol) -> Node:
        kind = symbol.type
        node = Node(symbol.path, _parent(symbol.path), symbol.name, about=symbol.comment)
        if isinstance(kind, ArrayType):
            is_whole = _value_type(kind.element) is not None and kind.count <= MOST_ELEMENTS
            return _described(node, kind.element if is_whole else kind, symbol, kind.count if is_whole else None)
        return _described(node, kind, symbol, None)


class _Elements(Sequence[Node]):
    """The elements of an array as nodes, of which only those that are asked for are made."""

    def __init__(self, kind: ArrayType, node: Callable[[int], Node]) -> None:
        self._kind, self._node = kind, node

    def __len__(self) -> int:
        return self._kind.count

    @overload
    def __getitem__(self, place: int) -> Node: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[Node]: ...

    def __getitem__(self, place: int | slice) -> Node | Sequence[Node]:
        indices = range(self._kind.low, self._kind.high + 1)[place]
        return [self._node(index) for index in indices] if isinstance(indices, range) else self._node(indices)


def _parent(path: str) -> str:
    """Return the path that leads to this one: `a` for `a.b` and `a[1]`, `a[1]` for `a[1,2]`."""
    cut = max(path.rfind("."), path.rfind("["), path.rfind(","))
    return "" if cut < 0 else f"{path[:cut]}]" if path[cut] == "," else path[:cut]


def _value_type(kind: Type) -> str | None:
    """Return the name of the type of a value; None for what consists of parts."""
    match kind:
        case Elementary():
            return str(kind.value)
        case StringType():
            return kind.name
        case EnumType():
            return "ENUM"
        case SubrangeType():
            return str(kind.base.value)
        case PointerType() | ObjectType():
            return "DWORD"
        case _:
            return None


def _described(node: Node, kind: Type, symbol: Symbol, length: int | None) -> Node:
    type_name = _value_type(kind)
    return Node(
        node.path,
        node.parent,
        node.name,
        Kind.OBJECT if type_name is None else Kind.VARIABLE,
        type_name or "",
        length,
        symbol.is_writable and type_name is not None,
        type_name is None or length is not None,
        _UNITS.get(kind, "") if isinstance(kind, Elementary) else "",
        node.about,
        kind.low if isinstance(kind, SubrangeType) else None,
        kind.high if isinstance(kind, SubrangeType) else None,
        tuple(kind.values.items()) if isinstance(kind, EnumType) else (),
    )
