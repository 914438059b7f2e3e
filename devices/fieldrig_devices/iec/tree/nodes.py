"""The common part of the tree: positions in the source text, and the comments around statements."""

from dataclasses import dataclass, field
from typing import NamedTuple


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
