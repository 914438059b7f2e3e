"""Places in a tree, as the way that leads there, and trees with another part at a place."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any, Final, NamedTuple

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.tree.types import TypeSpec

Way = tuple[str | int, ...]
"""The names of fields, and the numbers within tuples, that lead to a part of a tree."""

_SKIPPED: Final = (*TypeSpec.__args__, tree.TaskDeclaration, tree.NativeBody)
"""Bounds of types and the times of tasks are the design of a program, and not its steps."""


class Found(NamedTuple):
    """A node of a tree."""

    way: Way
    node: tree.Node
    position: tree.Position
    """Its own, or else that of the node around it."""
    statement: tree.Position
    """The position of the statement to which it belongs."""


def walk(root: object) -> Iterator[Found]:
    """Yield all nodes of the code within a tree, in their order.

    The list of what waits is no recursion: expressions may be long.
    """
    waiting: list[tuple[Way, Any, tree.Position, tree.Position]] = [((), root, tree.NOWHERE, tree.NOWHERE)]
    while waiting:
        way, part, position, statement = waiting.pop()
        if isinstance(part, _SKIPPED):
            continue
        if isinstance(part, tree.Node):
            position = part.position if part.position != tree.NOWHERE else position
            statement = position if isinstance(part, tree.Statement) else statement
            yield Found(way, part, position, statement)
        waiting.extend(((*way, step), inner, position, statement) for step, inner in reversed(list(_parts(part))))


def _parts(part: object) -> Iterator[tuple[str | int, object]]:
    if isinstance(part, tuple | list):
        yield from enumerate(part)
    elif is_dataclass(part) and not isinstance(part, type):
        for one in fields(part):
            if one.compare and not (isinstance(part, tree.CaseBranch) and one.name == "labels"):
                yield one.name, getattr(part, one.name)


def replaced(root: Any, way: Way, part: object) -> Any:
    """Return a tree with another part at a place; the given one stays as it is."""
    around = [root]
    for step in way[:-1]:
        around.append(around[-1][step] if isinstance(step, int) else getattr(around[-1], step))
    for node, step in zip(reversed(around), reversed(way), strict=True):
        part = (*node[:step], part, *node[step + 1 :]) if isinstance(step, int) else replace(node, **{step: part})
    return part
