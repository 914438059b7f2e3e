"""The objects of a master's application by node, for tools that name the frames of its ring.

A device says so by the method `ring_objects` of its settings.
"""

from collections.abc import Mapping
from typing import NamedTuple, Protocol, runtime_checkable


class DescribedObject(NamedTuple):
    """An object of the application that is an item of a node."""

    name: str
    kind: str
    """Its class in the application, such as `BINARY_INPUT`."""
    units: float = 0.0
    """Resolver units in a unit of an axis; 0 for anything else."""


class DescribedNode(NamedTuple):
    """A node that the application declares."""

    name: str
    objects: tuple[DescribedObject, ...]
    """The first one is item 1."""


@runtime_checkable
class HasRingObjects(Protocol):
    """The settings of a master with an application."""

    def ring_objects(self) -> Mapping[int, DescribedNode]:
        """Return the nodes of the application by their addresses; none if it cannot be compiled."""
