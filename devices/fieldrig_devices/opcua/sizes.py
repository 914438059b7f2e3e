"""The sizes of nodes and values in messages to the server: texts and arrays of a program may be of any length."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Final, TypeVar

from fieldrig_bus.opcua import codec
from fieldrig_bus.opcua.message import LONGEST_PATH, LONGEST_TEXT, MOST_ELEMENTS, Node, Outcome, Status

Part = TypeVar("Part", Node, Outcome)

ROOM: Final = codec.LONGEST - 1_000
"""Bytes for the parts of a message, besides its head."""


def fitting(parts: Iterable[Part]) -> tuple[Part, ...]:
    """Return the first parts that fit into one message, at least one; the server asks for the rest."""
    found, room = list[Part](), ROOM
    for part in parts:
        room -= codec.size(part)
        if room < 0 and found:
            break
        found.append(part)
    return tuple(found)


def fits(part: Node | Outcome) -> bool:
    """True if a message can have this part."""
    return codec.size(part) <= ROOM


def sendable(node: Node) -> Node:
    """Return the node with a shorter text, and without the names of an enumeration that has too many."""
    node = replace(node, about=node.about[:LONGEST_TEXT], unit=node.unit[:LONGEST_PATH])
    is_long = len(node.choices) > MOST_ELEMENTS or any(len(name) > LONGEST_PATH for name, _ in node.choices)
    return replace(node, choices=()) if is_long or not fits(node) else node


def refusal(status: Status, cause: Exception) -> Outcome:
    return Outcome(status, text=str(cause)[:LONGEST_TEXT])
