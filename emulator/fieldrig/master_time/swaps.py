"""Replaces the real calls by the stand-ins, and puts the real calls back.

A call is found by its identity wherever a loaded module has it: under any name, as an attribute of a class, or as the
default of an argument.  So `from time import sleep` and `def __init__(self, clock=time.monotonic)` are covered as well.
Kinds are compared by `type(x)`: some modules have objects that do more than they should when they are asked for
anything, such as the placeholder network of python canopen, which raises.
"""

import sys
import types
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, Final

from fieldrig.master_time.locks import Lock
from fieldrig.master_time.member import new_lock

SKIPPED: Final = (
    "_pytest", "pytest", "pluggy", "pytest_timeout", "xdist", "execnet", "faulthandler", "importlib", "hypothesis",
    "coverage", "_frozen_importlib", "_frozen_importlib_external", "pydevd", "debugpy",
)  # fmt: skip
"""Packages of the tools around a test, which keep real time."""
OURS: Final = "fieldrig.master_time"
_LOCK: Final = type(new_lock())
_MISSING: Final = object()


def is_of_tool(module: str) -> bool:
    """True for a module of the tools around a test."""
    return module.partition(".")[0] in SKIPPED


class Swaps:
    """The list of all replacements, in their order."""

    def __init__(self) -> None:
        self._undo: list[Callable[[], None]] = []

    def attribute(self, owner: Any, name: str, value: Any) -> None:
        """Set an attribute of a module or a class."""
        before = vars(owner).get(name, _MISSING)

        def undo() -> None:
            if before is _MISSING:
                delattr(owner, name)
            else:
                setattr(owner, name, before)

        setattr(owner, name, value)
        self._undo.append(undo)

    def item(self, table: Any, key: Any, value: Any) -> None:
        """Set an entry of a mapping."""
        before = table.get(key, _MISSING)

        def undo() -> None:
            if before is _MISSING:
                del table[key]
            else:
                table[key] = before

        table[key] = value
        self._undo.append(undo)

    def later(self, undo: Callable[[], None]) -> None:
        """Call this at the end as well."""
        self._undo.append(undo)

    def everywhere(self, pairs: Iterable[tuple[Any, Any]]) -> None:
        """Replace the first of each pair by the second in all modules."""
        pairs = list(pairs)
        stand_ins = {id(real): stand_in for real, stand_in in pairs}
        for name, module in list(sys.modules.items()):
            space = getattr(module, "__dict__", None) if module is not None else None
            if type(space) is dict and not is_of_tool(name) and not name.startswith(OURS):
                self._module(module, name, space, stand_ins)

    def undo(self) -> None:
        while self._undo:
            self._undo.pop()()

    def _module(self, module: Any, name: str, space: dict[str, Any], stand_ins: dict[int, Any]) -> None:
        for key, value in list(space.items()):
            kind = type(value)
            if id(value) in stand_ins:
                self.attribute(module, key, stand_ins[id(value)])
            elif kind is _LOCK and not value.locked():  # made at import; a member may hold it over a wait
                self.attribute(module, key, Lock())
            elif kind is types.FunctionType:
                self._defaults(value, stand_ins)
            elif isinstance(kind, type) and issubclass(kind, type) and vars(value).get("__module__") == name:
                self._class(value, stand_ins)

    def _class(self, owner: type, stand_ins: dict[int, Any]) -> None:
        for key, value in list(vars(owner).items()):
            if type(value) is types.FunctionType:
                self._defaults(value, stand_ins)
            elif id(value) in stand_ins:
                self.attribute(owner, key, stand_ins[id(value)])

    def _defaults(self, function: types.FunctionType, stand_ins: dict[int, Any]) -> None:
        for name in ("__defaults__", "__kwdefaults__"):
            before = getattr(function, name)
            if not before:
                continue
            values = before.values() if name == "__kwdefaults__" else before
            if not any(id(value) in stand_ins for value in values):
                continue
            if name == "__kwdefaults__":
                after: Any = {key: stand_ins.get(id(value), value) for key, value in before.items()}
            else:
                after = tuple(stand_ins.get(id(value), value) for value in before)
            setattr(function, name, after)
            self._undo.append(partial(setattr, function, name, before))
