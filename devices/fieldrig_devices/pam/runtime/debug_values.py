"""Variables and objects of an application for the debugger, by their names; `IFV_Each[2]` is the second item."""

import re
from collections.abc import Iterator, Sequence
from typing import Final

from fieldrig.device import Value
from fieldrig.text.nearest import closest
from fieldrig_devices.languages.debugging.debuggee import Variable
from fieldrig_devices.pam.language.functions import VALUES, WRITABLE
from fieldrig_devices.pam.language.items import Routines
from fieldrig_devices.pam.runtime.item import Item, Pending
from fieldrig_devices.pam.runtime.item import Value as Number
from fieldrig_devices.pam.runtime.layout import Cells
from fieldrig_devices.pam.runtime.lower.operands import HIGH, LOW
from fieldrig_devices.pam.runtime.runtime import Runtime

_PATH: Final = re.compile(r"(\w+)(?:\[(\d{1,6})\])?", re.ASCII)
_FLAGS: Final = {"true": True, "set": True, "1": True, "false": False, "reset": False, "0": False}


class Values:
    def __init__(self, runtime: Runtime) -> None:
        self._runtime, self._layout = runtime, runtime.program.layout

    # ---- reading

    def variables(self, path: str) -> Sequence[Variable]:
        if not path:
            return [self._root(name) for name in self._names()]
        name, number = self._parts(path)
        if number is not None:
            return []
        return [self._one(name, item) for item in range(self._count(name))] if self._is_group(name) else []

    def _names(self) -> Iterator[str]:
        """Yield what has a value: variables, equations, inputs and outputs.  Encoders are asked by expressions only."""
        yield from self._layout.cells
        for name in self._layout.kinds:
            if name not in self._layout.cells and self._has_value(name):
                yield name

    def _has_value(self, name: str) -> bool:
        """True for one of these names; a watched point is read several thousand times a second, so no list is made."""
        if name in self._layout.cells:
            return True
        kind = self._layout.kinds.get(name)
        return kind in VALUES and kind != "ENCODER" and name in self._runtime.items

    def _count(self, name: str) -> int:
        return self._layout.counts[name]

    def _is_group(self, name: str) -> bool:
        cells = self._layout.cells.get(name)
        return cells.is_multiple if cells is not None else self._count(name) > 1

    def _parts(self, path: str) -> tuple[str, int | None]:
        """Return the name and the item, from 0, of a path.  ValueError for what is no variable."""
        match = _PATH.fullmatch(path)
        name = match[1] if match is not None else ""
        if match is None or not self._has_value(name):
            near = closest(name, list(self._names()))
            raise ValueError(f"{path} is not a variable or an input or output: {near}")
        if match[2] is None:
            return name, None
        if not self._is_group(name) or not 1 <= int(match[2]) <= self._count(name):
            raise ValueError(f"{path}: expected an item from 1 to {self._count(name)}")
        return name, int(match[2]) - 1

    def _root(self, name: str) -> Variable:
        if self._is_group(name):
            return Variable(name, name, f"{self._layout.kinds[name]} [{self._count(name)}]")
        return self._one(name, None)

    def _one(self, name: str, number: int | None) -> Variable:
        path = name if number is None else f"{name}[{number + 1}]"
        cells = self._layout.cells.get(name)
        kind = self._layout.kinds[name]
        if cells is None:
            value = self._item(name, number).value()
            shown = None if isinstance(value, Pending) else value
            return Variable(path, path, kind, shown, kind in WRITABLE)
        cell = cells.first + (number or 0)
        is_forced = cell in self._runtime.forced
        return Variable(path, path, kind, self._runtime.cells[cell], not cells.is_equation, is_forced)

    def _item(self, name: str, number: int | None) -> Item:
        return self._runtime.items[name][number or 0]

    def evaluate(self, text: str, item: int) -> Variable:
        """Return a variable by its path, or the value of an expression in which [i] is this item."""
        try:
            name, number = self._parts(text.strip())
        except ValueError as unknown:
            value = self._expression(text, item, unknown)
            return Variable(text, text, _TYPES[type(value)], value)
        return self._root(name) if number is None else self._one(name, number)

    def _expression(self, text: str, item: int, unknown: ValueError) -> Number:
        """Return the value of an expression.  A wrong name alone raises `unknown`, which proposes another one."""
        try:
            return self._runtime.watch.value(text, item)
        except ValueError:
            if _PATH.fullmatch(text.strip()) is not None:
                raise unknown from None
            raise

    def formals(self, routine: str, frame: int) -> Sequence[Variable]:
        """Return the formal parameters of the code of a routine, whose cells begin at `frame`."""
        if not routine.startswith("routine "):
            return []
        _, name, *types = routine.split()
        declared = [
            one
            for group in self._runtime.program.program.items
            if isinstance(group, Routines)
            for one in group.routines
        ]
        formals = next(one.formals for one in declared if one.name == name)
        pairs = zip(formals, types, strict=True)
        return [
            Variable(formal, formal, kind, self._runtime.cells[frame + slot])
            for slot, (formal, kind) in enumerate(pairs)
        ]

    # ---- writing

    def write(self, path: str, value: Value) -> None:
        name, number = self._parts(path)
        kind = self._layout.kinds[name]
        cells = self._layout.cells.get(name)
        if self._is_group(name) and number is None:
            raise ValueError(f"{path} has {self._count(name)} items: expected {path}[1] to {path}[{self._count(name)}]")
        if cells is not None:
            self._runtime.poke(self._cell(path, cells, number), typed(path, kind, value))
        elif kind in WRITABLE:
            self._item(name, number).set_value(typed(path, kind, value))
        else:
            self._runtime.write_input(self._item(name, number), path, typed(path, kind, value))

    @staticmethod
    def _cell(path: str, cells: Cells, number: int | None) -> int:
        if cells.is_equation:
            raise ValueError(f"{path} is an equation: expected one of its operands")
        return cells.first + (number or 0)

    def force(self, path: str, value: Value | None) -> None:
        name, number = self._parts(path)
        cells = self._layout.cells.get(name)
        if cells is None or (cells.is_multiple and number is None):
            raise ValueError(f"{path} cannot be forced: expected a single variable of the application")
        cell = self._cell(path, cells, number)
        if value is None:
            self._runtime.forced.pop(cell, None)
            return
        forced = typed(path, self._layout.kinds[name], value)
        self._runtime.forced[cell] = forced
        self._runtime.poke(cell, forced)

    def forced(self) -> Sequence[Variable]:
        cells = self._layout.cells.values()
        places = [(each, number) for each in cells for number in range(each.count)]
        return [
            self._one(each.name, number if each.is_multiple else None)
            for each, number in places
            if each.first + number in self._runtime.forced
        ]


def typed(path: str, kind: str, value: Value) -> Number:
    """Return a value for a variable of this kind; a text is a constant of the language.  ValueError if it is none."""
    wanted = VALUES[kind]
    if wanted == "flag":
        flag = _FLAGS.get(str(value).strip().lower())
        if flag is None:
            raise ValueError(f"{path}: expected true or false, got {value!r}")
        return flag
    try:
        number = _number(value)
    except ValueError as cause:
        raise ValueError(f"{path}: expected a number, got {value!r}") from cause
    if wanted == "real":
        return float(number)
    if not LOW <= number <= HIGH:
        raise ValueError(f"{path}: expected a number from {LOW} to {HIGH}, got {value!r}")
    return int(number)


def _number(value: Value) -> int | float:
    if not isinstance(value, str):
        return value
    text = value.strip()
    if text.startswith("#"):
        return int(text[1:], 16)
    number = float(text) if "." in text else int(text)
    if isinstance(number, float) and number - number != 0:
        raise ValueError(text)
    return number


_TYPES: Final = {bool: "flag", int: "integer", float: "real"}
