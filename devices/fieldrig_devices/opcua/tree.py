"""The nodes of a device for OPC UA: what a device implements, and how several trees become one."""

from collections.abc import Sequence
from typing import Protocol

from fieldrig_bus.opcua.message import AnyValue, Node, Status


class UnknownNodeError(Exception):
    """There is no node with this path."""


class WrongArgumentsError(Exception):
    """Arguments of a method are not accepted; `statuses` has one for each."""

    def __init__(self, *statuses: Status) -> None:
        super().__init__(", ".join(status.value for status in statuses))
        self.statuses = statuses


class NodeTree(Protocol):
    """Nodes by their paths.  Reading changes nothing."""

    def children(self, path: str) -> Sequence[Node]:
        """Return the children of a node, or those without a parent for an empty path; nothing for an unknown one."""

    def find(self, path: str) -> Node | None: ...

    def read(self, path: str) -> AnyValue:
        """Return the value at the present instant.  UnknownNodeError if there is no such variable."""

    def write(self, path: str, value: AnyValue) -> None:
        """Write a variable.  ValueError for a value that it cannot have, TypeError for a wrong type."""

    def call(self, path: str, arguments: Sequence[AnyValue]) -> Sequence[AnyValue]:
        """Call a method with as many arguments as it has, and return its results.

        UnknownNodeError; WrongArgumentsError; ValueError, with the reason, if it is not possible now.
        """


class Trees:
    """Several trees side by side; the first one that knows a path has it."""

    def __init__(self, trees: Sequence[NodeTree]) -> None:
        self._trees = trees

    def children(self, path: str) -> Sequence[Node]:
        found: dict[str, Node] = {}
        for tree in self._trees:
            for node in tree.children(path):
                found.setdefault(node.path, node)
        return list(found.values())

    def find(self, path: str) -> Node | None:
        return next((node for tree in self._trees if (node := tree.find(path)) is not None), None)

    def read(self, path: str) -> AnyValue:
        return self._of(path).read(path)

    def write(self, path: str, value: AnyValue) -> None:
        self._of(path).write(path, value)

    def call(self, path: str, arguments: Sequence[AnyValue]) -> Sequence[AnyValue]:
        return self._of(path).call(path, arguments)

    def _of(self, path: str) -> NodeTree:
        for tree in self._trees:
            if tree.find(path) is not None:
                return tree
        raise UnknownNodeError(path)
