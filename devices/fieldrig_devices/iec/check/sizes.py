"""Sizes in bytes of structures and instances, and structures that would contain themselves.

Components follow one another without gaps (`types.py`).  A reference takes 4 bytes; a located variable takes none.
"""

from collections.abc import Iterable
from enum import Enum
from typing import Final

from fieldrig_devices.iec.check.project import UNKNOWN, Project
from fieldrig_devices.iec.program import Pou, Space, Variable
from fieldrig_devices.iec.types import ArrayType, BlockType, StructType, Type

REFERENCE: Final = 4
DEEPEST: Final = 40
"""Levels of structures and instances in one another; CoDeSys V2.3 has no use for more."""


class Refused(Enum):
    CIRCLE = "contains itself"
    DEEP = "is nested too deeply"
    LARGE = "has too many parts"


class Sizes:
    def __init__(self, project: Project) -> None:
        self._project = project
        self._known: set[Type] = set()
        self._busy: list[StructType | BlockType] = []
        self._depths: dict[Type, int] = {}
        self._parts: dict[Type, int] = {}
        self.refused: dict[StructType | BlockType, Refused] = {}
        """Types that cannot be used, with the reason; their size is 0."""

    def of(self, kind: Type) -> int:
        """Return the size; set it in structures and function blocks that are met on the way."""
        if isinstance(kind, ArrayType):
            return kind.count * self.of(kind.element)
        if not isinstance(kind, StructType | BlockType):
            return kind.size
        if kind in self._known or kind is UNKNOWN:
            return kind.size
        if kind in self._busy:
            return self._refuse(kind, Refused.CIRCLE)
        if len(self._busy) >= DEEPEST:
            return self._refuse(kind, Refused.DEEP)
        self._busy.append(kind)
        kind.size = self._structure(kind) if isinstance(kind, StructType) else self.instance(kind.pou)
        self._busy.pop()
        self._known.add(kind)
        parts = list(_parts(kind))
        self._depths[kind] = 1 + max(map(self._depth, parts), default=0)
        self._parts[kind] = 1 + sum(map(self.parts, parts))
        if self._depths[kind] > DEEPEST:
            self._refuse(kind, Refused.DEEP)
        elif self._parts[kind] > self._project.limits.parts:
            self._refuse(kind, Refused.LARGE)
        return kind.size

    def parts(self, kind: Type) -> int:
        """Return of how many parts a type is: it and all components and elements in it, also those without a size."""
        if isinstance(kind, ArrayType):
            return 1 + kind.count * self.parts(kind.element)
        return self._parts.get(kind, 1) if isinstance(kind, StructType | BlockType) else 1

    def _refuse(self, kind: StructType | BlockType, why: "Refused") -> int:
        """Note a type that cannot be used; whatever contains it does without it."""
        self.refused.setdefault(kind, why)
        kind.size = self._depths[kind] = self._parts[kind] = 0
        return 0

    def cut(self) -> None:
        """Take the refused types out of those that contain them, so that whatever follows all parts comes to an end."""
        for kind in list(self._known):
            if isinstance(kind, StructType):
                for field in kind.fields.values():
                    field.type = self._allowed(field.type)
            elif isinstance(kind, BlockType) and kind.pou is not None:
                for variable in kind.pou.variables.values():
                    variable.type = variable.type if variable.is_reference else self._allowed(variable.type)

    def _allowed(self, kind: Type) -> Type:
        plain = kind
        while isinstance(plain, ArrayType):
            plain = plain.element
        return UNKNOWN if plain in self.refused else kind

    def _depth(self, kind: Type) -> int:
        while isinstance(kind, ArrayType):
            kind = kind.element
        return self._depths.get(kind, 0) if isinstance(kind, StructType | BlockType) else 0

    def _structure(self, kind: StructType) -> int:
        if kind.is_union:
            return max((self.of(field.type) for field in kind.fields.values()), default=0)
        offset, bits = 0, 0
        for field in kind.fields.values():
            if field.bit < 0:
                field.offset, bits = offset, 0
                offset += self.of(field.type)
                continue
            if not bits % 8:
                offset += 1
            field.offset, field.bit = offset - 1, bits % 8
            bits += 1
        return offset

    def instance(self, pou: Pou | None) -> int:
        if pou is None:
            return 0
        return sum(self.variable(variable) for variable in pou.variables.values() if variable.space is Space.INSTANCE)

    def frame(self, pou: Pou) -> int:
        """Bytes on the stack: the variables of a function, or VAR_TEMP of another POU."""
        size = sum(self.variable(size) for size in pou.variables.values() if size.space is Space.FRAME)
        return size + (self.of(pou.result.type) if pou.result is not None else 0)

    def variable(self, variable: Variable) -> int:
        if variable.location is not None:
            return 0
        return REFERENCE if variable.is_reference else self.of(variable.type)


def _parts(kind: StructType | BlockType) -> Iterable[Type]:
    if isinstance(kind, StructType):
        return [field.type for field in kind.fields.values()]
    variables = kind.pou.variables.values() if kind.pou is not None else ()
    return [variable.type for variable in variables if variable.space is Space.INSTANCE and not variable.is_reference]
