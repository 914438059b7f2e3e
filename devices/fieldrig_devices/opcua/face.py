"""A device's end of an OPC UA bus: it answers the requests of the server from the device's nodes."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Final, TypeVar

from fieldrig.link import Link
from fieldrig_bus.opcua import codec, message
from fieldrig_bus.opcua.message import LONGEST_PATH, LONGEST_TEXT, MOST_ELEMENTS, Node, Outcome, Status
from fieldrig_devices.opcua.tree import NodeTree, UnknownNodeError, WrongArgumentsError

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


DONE: Final = message.Outcome(message.Status.GOOD)
UNKNOWN: Final = message.Outcome(message.Status.UNKNOWN)


class OpcUaFace:
    """Create it with the device, and call `offer` at power-on and whenever the nodes have changed."""

    def __init__(self, name: str, about: str, link: Link[message.OpcUaMessage], tree: Callable[[], NodeTree]) -> None:
        """`tree` returns the present nodes."""
        self._name, self._about, self._link, self._tree = name, about, link, tree
        self._generation = 0
        link.on_receive(self._on_message)

    def offer(self) -> None:
        self._generation += 1
        self._link.send(message.Offer(self._name, self._about, self._generation))

    def _on_message(self, request: message.OpcUaMessage) -> None:
        tree = self._tree()
        match request:
            case message.Browse(_, exchange, path, first):
                first = max(first, 0)
                children = tree.children(path)
                nodes = fitting(sendable(node) for node in children[first : first + message.MOST_NODES])
                self._link.send(message.Nodes(exchange, nodes, first + len(nodes) >= len(children)))
            case message.Find(_, exchange, path):
                node = tree.find(path)
                self._link.send(message.Nodes(exchange, () if node is None else (sendable(node),)))
            case message.Read(_, exchange, paths):
                self._link.send(message.Outcomes(exchange, fitting(_read(tree, path) for path in paths)))
            case message.Write(_, exchange):
                self._link.send(message.Outcomes(exchange, (_written(tree, request),)))
            case message.Call(_, exchange):
                self._link.send(message.Outcomes(exchange, (_called(tree, request),)))
            case _:
                pass  # an answer of another device


def _read(tree: NodeTree, path: str) -> message.Outcome:
    try:
        outcome = message.Outcome(message.Status.GOOD, tree.read(path))
    except UnknownNodeError:
        return UNKNOWN
    except ValueError as cause:
        return refusal(message.Status.REFUSED, cause)
    return outcome if fits(outcome) else message.Outcome(message.Status.TOO_LARGE)


def _written(tree: NodeTree, request: message.Write) -> message.Outcome:
    node = tree.find(request.path)
    if node is None:
        return UNKNOWN
    if node.kind is not message.Kind.VARIABLE or not node.is_writable:
        return message.Outcome(message.Status.NOT_WRITABLE)
    try:
        tree.write(request.path, request.value)
    except UnknownNodeError:
        return UNKNOWN
    except TypeError as cause:
        return refusal(message.Status.TYPE_MISMATCH, cause)
    except ValueError as cause:
        return refusal(message.Status.OUT_OF_RANGE, cause)
    return DONE


def _called(tree: NodeTree, request: message.Call) -> message.Outcome:
    node = tree.find(request.path)
    if node is None or node.kind is not message.Kind.METHOD:
        return UNKNOWN
    if len(request.arguments) != len(node.arguments):
        return message.Outcome(message.Status.REFUSED, text=f"expected {len(node.arguments)} arguments")
    try:
        results = tree.call(request.path, request.arguments)
    except UnknownNodeError:
        return UNKNOWN
    except WrongArgumentsError as cause:
        return message.Outcome(message.Status.WRONG_ARGUMENTS, arguments=cause.statuses)
    except ValueError as cause:
        return refusal(message.Status.REFUSED, cause)
    outcome = message.Outcome(message.Status.GOOD, results=tuple(results))
    return outcome if fits(outcome) else message.Outcome(message.Status.TOO_LARGE)
