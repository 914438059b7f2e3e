"""Sizes in bytes of structures and instances, and structures that would contain themselves.

Components follow one another without gaps (`types.py`).  A reference takes 4 bytes; a located variable takes none.
"""

from collections.abc import Iterable
from typing import Final

from fieldrig_devices.iec.check.project import Project
from fieldrig_devices.iec.program import Pou, Space, Variable
from fieldrig_devices.iec.types import ArrayType, BlockType, StructType, Type

REFERENCE: Final = 4
DEEPEST: Final = 40
"""Levels of structures and instances in one another; CoDeSys V2.3 has no use for more."""


class Sizes:
    def __init__(self, project: Project) -> None:
        self._project = project
        self._known: set[Type] = set()
        self._busy: list[StructType | BlockType] = []
        self._depths: dict[Type, int] = {}
        self.deep: list[StructType | BlockType] = []
        """Types with more levels of components than DEEPEST."""
        self.circles: list[StructType | BlockType] = []
        """Types that contain themselves; their size stays 0."""

    def of(self, kind: Type) -> int:
        """Return the size; set it in structures and function blocks that are met on the way."""
        if isinstance(kind, ArrayType):
            return kind.count * self.of(kind.element)
        if not isinstance(kind, StructType | BlockType):
            return kind.size
        if kind in self._known:
            return kind.size
        if kind in self._busy:
            self.circles.append(kind)
            return 0
        if len(self._busy) >= DEEPEST:
            self.deep.append(kind)
            return 0
        self._busy.append(kind)
        kind.size = self._structure(kind) if isinstance(kind, StructType) else self.instance(kind.pou)
        self._busy.pop()
        self._known.add(kind)
        self._depths[kind] = 1 + max((self._depth(part) for part in _parts(kind)), default=0)
        if self._depths[kind] == DEEPEST + 1:
            self.deep.append(kind)
        return kind.size

    def _depth(self, kind: Type) -> int:
        while isinstance(kind, ArrayType):
            kind = kind.element
        return self._depths.get(kind, 0) if isinstance(kind, StructType | BlockType) else 0

    def _structure(self, kind: StructType) -> int:
        if kind.is_union:
            return max((self.of(field.type) for field in kind.fields.values()), default=0)
        offset = 0
        for field in kind.fields.values():
            field.offset = offset
            offset += self.of(field.type)
        return offset

    def instance(self, pou: Pou | None) -> int:
        if pou is None:
            return 0
        return sum(self.variable(found) for found in pou.variables.values() if found.space is Space.INSTANCE)

    def frame(self, pou: Pou) -> int:
        """Bytes on the stack: the variables of a function, or VAR_TEMP of another POU."""
        found = sum(self.variable(found) for found in pou.variables.values() if found.space is Space.FRAME)
        return found + (self.of(pou.result.type) if pou.result is not None else 0)

    def variable(self, variable: Variable) -> int:
        if variable.location is not None:
            return 0
        return REFERENCE if variable.is_reference else self.of(variable.type)


def _parts(kind: StructType | BlockType) -> Iterable[Type]:
    if isinstance(kind, StructType):
        return [field.type for field in kind.fields.values()]
    variables = kind.pou.variables.values() if kind.pou is not None else ()
    return [variable.type for variable in variables if variable.space is Space.INSTANCE and not variable.is_reference]
