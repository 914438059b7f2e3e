"""The variables of a routine that stands within a cycle, also of the callers of the innermost one.

A path `@1:2.x` is the variable x of frame 2 of task 1, where frame 0 is the innermost one, and `@1:2` are all variables
of that frame.  A variable of an instance that has a path from the root is shown with that path.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec.layout import storage
from fieldrig_devices.iec.program import Pou, Space, Variable
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.symbols import Symbol, below
from fieldrig_devices.iec.thread import Thread
from fieldrig_devices.iec.types import ArrayType, BlockType, OpenArrayType, Type

MARK: Final = "@"
_PATH: Final = re.compile(r"@(\d{1,4}):(\d{1,6})(?:\.(.*))?", re.ASCII | re.DOTALL)


def parts_of(path: str) -> tuple[int, int, str]:
    """Return the task, the frame and the rest of a path.  ValueError, saying what was expected, for another form."""
    match = _PATH.fullmatch(path)
    if match is None:
        raise ValueError(f"expected @TASK:FRAME.NAME, such as @1:0.count, got {path!r}")
    return int(match[1]), int(match[2]), match[3] or ""


@dataclass(frozen=True, slots=True)
class Scope:
    """A routine with its variables in memory."""

    runtime: Runtime
    pou: Pou
    frame: int
    base: int
    prefix: str

    @classmethod
    def of(cls, runtime: Runtime, thread: Thread, task: int, number: int) -> "Scope | None":
        """Return the scope of a frame.  None for a routine without variables; ValueError for a frame that is not."""
        frames = thread.frames
        if number >= len(frames):
            raise ValueError(f"expected a frame from 0 to {len(frames) - 1}, got {number}" if frames else _BETWEEN)
        title, frame, base = frames[number]
        program = runtime.compiled.program
        first, *rest = map(program.dialect.key, title.split("."))
        pou = program.pous.get(".".join([first, *rest])) or program.pous.get(first)
        return None if pou is None else cls(runtime, pou, frame, base, f"{MARK}{task}:{number}")

    def symbols(self) -> Iterator[Symbol]:
        """Yield the variables, first the result of a function."""
        if self.pou.result is not None:
            yield self._symbol(self.pou.result)
        instance = self._instance()
        for variable in self._variables():
            if not variable.name.startswith("$"):
                yield self._shown(variable, instance)

    def find(self, path: str) -> Symbol | None:
        """Return a variable, or a part of one."""
        first = path.partition(".")[0].partition("[")[0]
        key = self.runtime.compiled.program.dialect.key
        names = {key(first), key(f"{self.pou.name.partition('.')[2]}.{first}")}  # the second one is of VAR_INST
        variable = next((known for known in self._variables() if key(known.name) in names), None)
        result = self.pou.result
        if variable is None and result is not None and key(result.name) == key(first):
            variable = result
        if variable is None:
            return None
        return below(self._shown(variable, self._instance()), path[len(first) :], key)

    def _variables(self) -> list[Variable]:
        """The variables of the routine, then those of the function block of a method."""
        owner = self.pou.owner
        return [*self.pou.variables.values(), *(owner.variables.values() if owner is not None else ())]

    def _shown(self, variable: Variable, instance: str | None) -> Symbol:
        known = None
        if variable.space is Space.INSTANCE and instance is not None:
            known = self.runtime.symbols.find(f"{instance}.{variable.name}")
        if known is None or isinstance(variable.type, OpenArrayType):
            return self._symbol(variable)
        return known

    def _symbol(self, variable: Variable) -> Symbol:
        start = {Space.FRAME: self.frame, Space.INSTANCE: self.base, Space.GLOBAL: 0}[variable.space]
        steps = (start + max(variable.offset, 0), *((0,) if variable.is_reference else ()))
        return Symbol(
            f"{self.prefix}.{variable.name}",
            variable.name,
            self._closed(variable.type),
            variable.comment,
            not variable.is_constant,
            steps=steps,
            location=variable.location,
        )

    def _closed(self, kind: Type) -> Type:
        """Return the type of an ARRAY[*] with the limits that it has now; other types as they are."""
        if not isinstance(kind, OpenArrayType):
            return kind
        cells = [(self.frame if one.space is Space.FRAME else self.base) + one.offset for one in kind.limits]
        low, high = (self.runtime.memory[cell] for cell in cells)
        assert isinstance(low, int)
        assert isinstance(high, int)
        return ArrayType(low, high, self._closed(kind.element))

    def _instance(self) -> str | None:
        """Return the path of the instance whose code runs.

        The first instance inside another one has the same address, so the name of the POU counts as well.
        """
        symbols, pou = self.runtime.symbols, self.pou.owner or self.pou
        waiting = list(symbols.children()) if pou.type is not None else []
        while waiting:
            symbol = waiting.pop()
            if isinstance(symbol.type, BlockType) and symbol.type.pou is pou and symbol.steps == (self.base,):
                return symbol.path
            if storage(symbol.type) is None:
                waiting += symbols.children(symbol.path)
        return None


_BETWEEN: Final = "the task is between two cycles: expected a breakpoint first"
