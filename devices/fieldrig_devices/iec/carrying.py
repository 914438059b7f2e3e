"""The values that a variable keeps in an online change although it gets another place.

A value goes to the part with the same name, or the same index, and the same type.  References of instances are not
kept: what they refer to may have moved as well.
"""

from collections.abc import Iterable, Iterator, Sequence

from fieldrig_devices.iec.layout import members, storage
from fieldrig_devices.iec.types import ArrayType, BlockType, StructType, Type

Run = tuple[int, int, int]
"""Consecutive cells that are kept: where they begin in the old and in the new variable, and how many there are."""


class Carrier:
    """The cells that variables of types of the old program pass on to variables of types of the new one."""

    def __init__(self) -> None:
        self._known: dict[tuple[Type, Type], Sequence[Run]] = {}
        self._references: dict[Type, Sequence[int]] = {}

    def runs(self, old: Type, new: Type) -> Sequence[Run]:
        if (old, new) not in self._known:
            self._known[old, new] = _joined(self._runs(old, new))
        return self._known[old, new]

    def _runs(self, old: Type, new: Type) -> Iterator[Run]:
        for source, target, before, after in _parts(old, new):
            for first, second, size in self.runs(before, after):
                yield source + first, target + second, size
        if storage(new) is not None and storage(old) == storage(new) and str(old) == str(new):
            yield 0, 0, new.size

    def references(self, kind: Type) -> Sequence[int]:
        """Return the offsets of the cells that refer to another variable, as a VAR_IN_OUT does."""
        if kind not in self._references:
            self._references[kind] = list(self._references_in(kind))
        return self._references[kind]

    def _references_in(self, kind: Type) -> Iterator[int]:
        match kind:
            case ArrayType(element=element, count=count):
                own = self.references(element)
                yield from (number * element.size + offset for number in range(count if own else 0) for offset in own)
            case StructType():
                for field in kind.stored_fields:
                    yield from (field.offset + offset for offset in self.references(field.type))
            case BlockType():
                for member in members(kind):
                    inside = (0,) if member.is_reference else self.references(member.type)
                    yield from (member.offset + offset for offset in inside)


def _parts(old: Type, new: Type) -> Iterator[tuple[int, int, Type, Type]]:
    """Yield the offsets and the types of the parts that both have."""
    match old, new:
        case ArrayType(), ArrayType():
            for index in range(max(old.low, new.low), min(old.high, new.high) + 1):
                first, second = (index - kind.low for kind in (old, new))
                yield first * old.element.size, second * new.element.size, old.element, new.element
        case StructType(), StructType():
            for name, field in new.fields.items():
                if name in old.fields and old.fields[name].bit == field.bit:
                    yield old.fields[name].offset, field.offset, old.fields[name].type, field.type
        case BlockType(), BlockType():
            known = {member.name.lower(): member for member in members(old) if not member.is_reference}
            for member in members(new):
                kept = known.get(member.name.lower())
                if kept is not None and not member.is_reference:
                    yield kept.offset, member.offset, kept.type, member.type


def _joined(runs: Iterable[Run]) -> Sequence[Run]:
    """Join runs that follow one another in both variables."""
    joined: list[Run] = []
    for source, target, size in runs:
        if joined and joined[-1][0] + joined[-1][2] == source and joined[-1][1] + joined[-1][2] == target:
            last = joined.pop()
            source, target, size = last[0], last[1], last[2] + size
        joined.append((source, target, size))
    return joined
