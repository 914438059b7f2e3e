"""Sizes in bytes of structures and instances, and structures that would contain themselves.

Components follow one another without gaps (`types.py`).  A reference takes 4 bytes; a located variable takes none.
"""

from fieldrig_devices.iec.check.project import Project
from fieldrig_devices.iec.program import Pou, Space, Variable
from fieldrig_devices.iec.types import ArrayType, BlockType, StructType, Type

REFERENCE = 4


class Sizes:
    def __init__(self, project: Project) -> None:
        self._project = project
        self._known: set[Type] = set()
        self._busy: list[StructType | BlockType] = []
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
        self._busy.append(kind)
        kind.size = self._structure(kind) if isinstance(kind, StructType) else self.instance(kind.pou)
        self._busy.pop()
        self._known.add(kind)
        return kind.size

    def _structure(self, kind: StructType) -> int:
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
