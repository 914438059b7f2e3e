"""An instance under test: its variables as attributes, its call, and its last changes for messages."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final

from fieldrig.errors import ArgumentError
from fieldrig.text.nearest import closest
from fieldrig_devices.iec.bench.changes import MOST_CHANGES, Change
from fieldrig_devices.iec.bench.owner import Functions, Owner
from fieldrig_devices.iec.bench.python_values import Placed, at, checker_of, write
from fieldrig_devices.iec.bench.views import view
from fieldrig_devices.iec.layout import members, storage
from fieldrig_devices.iec.program import Variable
from fieldrig_devices.iec.symbols import Symbol
from fieldrig_devices.iec.testing.reports.people import instant
from fieldrig_devices.iec.testing.texts import value_text
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import BlockType, PointerType, Type, Value

MOST_CALLS: Final = 64
"""Calls of an instance whose values are kept."""


def told(path: str, kind: Type, changes: Sequence[Change], declared: Variable | None) -> str:
    """Return a line with the value of a variable, those before it with their instants, and where it is declared."""
    before = ", ".join(f"{value_text(kind, value)} at {instant(at_ns)}" for at_ns, value in changes[-MOST_CHANGES:-1])
    at_ns, value = changes[-1]
    where = f"  ({declared.file}:{declared.position.line})" if declared is not None else ""
    since = f"since {instant(at_ns)}; before {before}" if before else "all the time"
    return f"{path} = {value_text(kind, value)} {since}{where}"


class Instance(Placed):
    """An instance of a block inside another one: `fb.timer.Q`."""

    __slots__ = ("_parts",)

    _parts: dict[str, Variable]

    def __init__(self, bench: Owner, path: str, kind: BlockType, address: int) -> None:
        self._keep(_bench=bench, _path=path)
        self._place_at(kind, address)

    def _keep(self, **values: Any) -> None:
        """Set attributes of our own; all others are variables of the instance."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _place_at(self, kind: BlockType, address: int) -> None:
        parts = {one.name.lower(): one for one in members(kind) if one.name[:1] != "$"}
        self._keep(_kind=kind, _address=address, _parts=parts)

    def __getattr__(self, name: str) -> Any:
        key, functions = name.lower(), self._functions_for(name)
        if key in functions.get("", ()):
            return functions[""][key]
        if key in functions.get("GET", ()):
            return functions["GET"][key]()
        symbol = self._symbol(name)
        if isinstance(symbol.type, BlockType):
            return Instance(self._bench, symbol.path, symbol.type, symbol.steps[0])
        return view(self._bench.runtime, symbol)

    def __setattr__(self, name: str, value: Any) -> None:
        key, functions = name.lower(), self._functions_for(name)
        if key in functions.get("SET", ()):
            functions["SET"][key](value)
        elif key in functions.get("GET", ()):
            raise ArgumentError(f"{self._path}.{name} cannot be set", "it is a property without SET")
        elif key in functions.get("", ()):
            raise ArgumentError(f"{self._path}.{name} cannot be set", f"it is a method: {name}(...) calls it")
        else:
            write(self._bench.runtime, self._symbol(name), value)

    def _functions_for(self, name: str) -> Functions:
        """Return the methods and properties, if the name is that of one."""
        is_variable = name.lower() in self._parts
        return {} if is_variable else self._bench.functions_at(self._kind, self._address, name)

    def _symbol(self, name: str) -> Symbol:
        """Return a variable.  AttributeError, with the nearest name, for an unknown one."""
        return self._located(name) or at(*self._place(name), f"{self._path}.{name}")

    def _located(self, name: str) -> Symbol | None:
        """Return a variable with an address, which is in an area and not in the instance."""
        pou = self._kind.pou
        known = pou.variables.values() if pou is not None else ()
        for one in known:
            if one.location is not None and one.name.lower() == name.lower() and storage(one.type) is not None:
                return Symbol(f"{self._path}.{name}", name, one.type, location=one.location)
        return None

    def _place(self, name: str) -> tuple[Type, int]:
        """Return type and address of a variable.  AttributeError for an unknown one."""
        variable = self._parts.get(name.lower())
        if variable is None:
            hint = closest(name, [one.name for one in self._parts.values()])
            raise AttributeError(f"{self._path} has no variable {name!r}; {hint}", name=name, obj=self)
        address = self._address + variable.offset
        return variable.type, int(self._bench.cells[address]) if variable.is_reference else address

    def __dir__(self) -> list[str]:
        return [one.name for one in self._parts.values()]

    def __repr__(self) -> str:
        return f"{self._path}({', '.join(self._texts())})"

    def _texts(self) -> list[str]:
        cells = self._bench.cells
        return [
            f"{one.name}={value_text(one.type, cells[self._address + one.offset])}"
            for one in self._parts.values()
            if storage(one.type) is not None and not one.is_reference
        ]


class Block(Instance):
    """An instance under test.  A call gives it inputs, runs its code once, and returns it."""

    __slots__ = ("_checks", "_functions", "_history", "_in_outs", "_opens", "_pointers", "_run")

    _checks: dict[str, tuple[Callable[[Any], Value], int]]
    _history: deque[tuple[int, list[Value]]]
    _functions: Functions
    _in_outs: Mapping[str, tuple[Type, int]]
    _opens: Mapping[str, Callable[[Any], None]]
    _pointers: Mapping[str, int]
    _run: Callable[[], None]

    def __init__(self, bench: Owner, name: str) -> None:
        """It can be used when `_bind` has given it its place."""
        self._keep(_bench=bench, _path=name, _parts={}, _functions={}, _history=deque(maxlen=MOST_CALLS))

    def _bind(
        self,
        kind: BlockType,
        address: int,
        run: Callable[[], None],
        in_outs: Mapping[str, tuple[Type, int]] = MappingProxyType({}),
        functions: Functions = MappingProxyType({}),
        pointers: Mapping[str, int] = MappingProxyType({}),
        opens: Mapping[str, Callable[[Any], None]] = MappingProxyType({}),
    ) -> None:
        """Use the code of the program as it is now.

        `in_outs` are the variables behind VAR_IN_OUT; `functions` are the methods, and GET and SET of properties;
        `pointers` are the addresses of the pointers to the instances that are passed to VAR_IN_OUT; `opens` give an
        argument without a type of its own the one that a value needs.
        """
        before = self._offsets()
        self._place_at(kind, address)
        self._keep(_run=run, _in_outs=in_outs, _functions=functions, _pointers=pointers, _opens=opens, _checks={})
        if self._offsets() != before:
            self._history.clear()

    def _offsets(self) -> dict[str, int]:
        return {name: one.offset for name, one in self._parts.items()}

    def _functions_for(self, name: str) -> Functions:
        return self._functions

    def __call__(self, *unnamed: Any, **inputs: Any) -> "Block":
        if unnamed:
            example = next(iter(self._inputs()), "name")
            raise ArgumentError(f"{self._path} is given {unnamed[0]!r} without a name", f"expected {example}=...")
        for name, value in inputs.items():
            self._give(name, value)
        self._run()
        self._history.append((self._bench.now_ns, self._bench.cells[self._address : self._address + self._kind.size]))
        return self

    def _give(self, name: str, value: Any) -> None:
        if (fit := self._opens.get(name.lower())) is not None:
            fit(value)
        pointer = self._pointers.get(name.lower())
        if pointer is not None:
            to = PointerType(self._in_outs[name.lower()][0])
            instance = value if isinstance(value, Placed) else None
            self._bench.cells[pointer] = checker_of(self._bench.runtime, to, f"{self._path}.{name}")(instance)
            if instance is not None:
                return
        check = self._checks.get(name)
        if check is None:
            kind, address = self._input(name)
            if storage(kind) is None:
                setattr(self, name, value)
                return
            check = self._checks[name] = checker_of(self._bench.runtime, kind, f"{self._path}.{name}"), address
        self._bench.cells[check[1]] = check[0](value)

    def _inputs(self) -> list[str]:
        """Return the names of VAR_INPUT."""
        return [one.name for one in self._parts.values() if one.section is Section.INPUT]

    def _kind_of(self, name: str) -> tuple[Type, str]:
        """Return the type and the path of an input.  ArgumentError for an unknown one."""
        return self._input(name)[0], f"{self._path}.{name}"

    def _input(self, name: str) -> tuple[Type, int]:
        """Return type and address of a variable that a call gives.  ArgumentError for an unknown one."""
        try:
            return self._place(name)
        except AttributeError as wrong:
            raise ArgumentError(*str(wrong).partition("; ")[::2]) from None

    def _forget(self) -> None:
        """Forget the calls so far."""
        self._history.clear()

    def _place(self, name: str) -> tuple[Type, int]:
        known, pointer = self._in_outs.get(name.lower()), self._pointers.get(name.lower())
        if known is not None and pointer is not None and self._bench.cells[pointer]:
            return known[0], int(self._bench.cells[pointer])
        return known if known is not None else super()._place(name)

    def __repr__(self) -> str:
        return f"{super().__repr__()} at {instant(self._bench.now_ns)}"

    def _told(self) -> list[str]:
        """Return a line for each variable that has changed: its value, and those before it with their instants."""
        lines = []
        for one in self._parts.values():
            if storage(one.type) is None or one.is_reference:
                continue
            changes = self._changes(one)
            if len(changes) > 1:
                lines.append(told(f"{self._path}.{one.name}", one.type, changes, one))
        return lines

    def _changes(self, one: Variable) -> list[Change]:
        changes: list[Change] = []
        for at_ns, cells in self._history:
            value = cells[one.offset]
            if not changes or changes[-1][1] != value:
                changes.append((at_ns, value))
        return changes
