"""All parts of a tree, in the order of the text."""

import dataclasses
from collections.abc import Iterator

from fieldrig_devices.pam.language.tree import Node


def nodes(*roots: object) -> Iterator[Node]:
    """Yield the nodes of these trees, each in front of its parts."""
    waiting = list(reversed(roots))
    while waiting:
        part = waiting.pop()
        if isinstance(part, tuple):
            if not hasattr(part, "_fields"):
                waiting += reversed(part)
        elif isinstance(part, Node):
            yield part
            waiting += [getattr(part, entry.name) for entry in reversed(dataclasses.fields(part))]
