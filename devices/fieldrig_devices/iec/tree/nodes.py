"""The common part of the tree: positions in the source text, and the comments around statements."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Final, NamedTuple


class Position(NamedTuple):
    """A position in a source text, counted from 1."""

    line: int
    column: int


NOWHERE = Position(0, 0)


@dataclass(slots=True)
class Node:
    position: Position = field(default=NOWHERE, compare=False, repr=False, kw_only=True)


@dataclass(slots=True)
class Statement(Node):
    comments: tuple[str, ...] = field(default=(), compare=False, repr=False, kw_only=True)
    """Comments in front of the statement, with their brackets."""
    remark: str = field(default="", compare=False, repr=False, kw_only=True)
    """A comment behind the statement in its last line."""
    is_spaced: bool = field(default=False, compare=False, repr=False, kw_only=True)
    """True if an empty line precedes it."""
    after: tuple[str, ...] = field(default=(), compare=False, repr=False, kw_only=True)
    """Comments behind the last statement of a block, in lines of their own."""


class _Parts(dict[type, tuple[str, ...]]):
    """The names of the parts of each kind of node, the last first; what is no node has none."""

    def __missing__(self, kind: type) -> tuple[str, ...]:
        parts = tuple(one.name for one in reversed(fields(kind)) if one.compare) if is_dataclass(kind) else ()
        self[kind] = parts
        return parts


_PARTS: Final = _Parts()


def walk(node: object) -> Iterator[object]:
    """Yield everything within a tree, itself first, in the order of the source; neither comments nor positions.

    The list of what waits is no recursion: expressions may be long.
    """
    waiting = [node]
    while waiting:
        part = waiting.pop()
        yield part
        if isinstance(part, tuple | list):
            waiting.extend(reversed(part))
        else:
            waiting.extend(getattr(part, name) for name in _PARTS[type(part)])
