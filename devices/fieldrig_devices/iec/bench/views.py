"""Arrays, structures and instances of a program as lists and dicts whose elements can be assigned to.

They have the values of the moment at which they were read.  What is assigned to an element goes to the program.
"""

from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from fieldrig.errors import ArgumentError, RigError
from fieldrig.text.nearest import closest
from fieldrig_devices.iec.bench.python_values import read, write
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.symbols import Symbol, parts
from fieldrig_devices.iec.types import ArrayType


def view(runtime: Runtime, symbol: Symbol) -> Any:
    """Return the value of a symbol; what is assigned to a part of an array or a structure goes to the program."""
    if symbol.is_value:
        return read(runtime, symbol)
    inside = [part for part in parts(symbol) if part.name[:1] != "$"]
    if not isinstance(symbol.type, ArrayType):
        return structure(runtime, symbol.path, inside)
    return Array(symbol.path, inside, _writer(runtime), [view(runtime, part) for part in inside])


def structure(runtime: Runtime, path: str, inside: Sequence[Symbol]) -> "Structure":
    """Return variables as the components of one structure."""
    return Structure(path, inside, _writer(runtime), [view(runtime, part) for part in inside])


Write = Callable[[Symbol, Any], Any]
"""Write a part, and return what it has then."""


def _writer(runtime: Runtime) -> Write:
    compiled = runtime.compiled

    def written(symbol: Symbol, value: Any) -> Any:
        if runtime.compiled is not compiled:
            raise RigError(
                f"{symbol.path} was read before a further block or mock came", "read it again, and then assign"
            )
        write(runtime, symbol, value)
        return view(runtime, symbol)

    return written


class Array(list[Any]):
    """The elements of an array, in the order of the indices, from 0."""

    __slots__ = ("_inside", "_path", "_write")

    def __init__(self, path: str, inside: Sequence[Symbol], write: Write, values: Sequence[Any]) -> None:
        super().__init__(values)
        self._path, self._inside, self._write = path, inside, write

    def __setitem__(self, index: Any, value: Any) -> None:
        if not isinstance(index, slice):
            super().__setitem__(index, self._write(self._inside[index], value))
            return
        places = range(*index.indices(len(self)))
        if len(places) != len(value):
            self._fixed()
        for place, one in zip(places, value, strict=True):
            self[place] = one

    def _fixed(self, *_: Any) -> NoReturn:
        raise ArgumentError(f"{self._path} always has {len(self)} elements", "assign to one of them")

    append = extend = insert = pop = remove = clear = __delitem__ = __iadd__ = __imul__ = _fixed

    def __reduce__(self) -> tuple[Any, ...]:
        return list, (list(self),)  # a copy is a plain list


class Structure(dict[str, Any]):
    """The components of a structure, or the variables of an instance, by their names, which are attributes as well."""

    __slots__ = ("_inside", "_path", "_write")

    def __init__(self, path: str, inside: Sequence[Symbol], write: Write, values: Sequence[Any]) -> None:
        super().__init__(zip((part.name for part in inside), values, strict=True))
        for name, own in (("_path", path), ("_write", write), ("_inside", {part.name: part for part in inside})):
            object.__setattr__(self, name, own)

    def _named(self, name: Any) -> str:
        """Return a name as it was declared.  ArgumentError for an unknown one."""
        found: str | None = next((one for one in self._inside if one.casefold() == str(name).casefold()), None)
        if found is None:
            raise ArgumentError(f"{self._path} has no {name}", closest(str(name), list(self._inside)))
        return found

    def __missing__(self, name: Any) -> Any:
        return self[self._named(name)]

    def __setitem__(self, name: Any, value: Any) -> None:
        known = self._named(name)
        super().__setitem__(known, self._write(self._inside[known], value))

    def __getattr__(self, name: str) -> Any:
        try:
            return self[self._named(name)]
        except ArgumentError as wrong:
            raise AttributeError(str(wrong), name=name, obj=self) from None

    def __setattr__(self, name: str, value: Any) -> None:
        self[name] = value

    def update(self, *others: Any, **named: Any) -> None:
        for name, value in dict(*others, **named).items():
            self[name] = value

    def _fixed(self, *_: Any) -> NoReturn:
        raise ArgumentError(f"{self._path} always has {', '.join(self._inside)}", "assign to one of them")

    pop = popitem = clear = setdefault = __delitem__ = _fixed

    def __reduce__(self) -> tuple[Any, ...]:
        return dict, (dict(self),)
