"""One device under virtual time: handed an instant and what arrived, it leaves what it sends, and says when it wants to
be called again.

A node is local, or remote in a process of its own (`remote_node`), with the same result.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from fieldrig.build import build_device
from fieldrig.clock import VirtualClock
from fieldrig.config import DeviceEntry
from fieldrig.device import Device, Point, Value
from fieldrig.errors import ControlError, refusals
from fieldrig.link import Link
from fieldrig.store import Store

BusName = str
Deliveries = Sequence[tuple[BusName, Any]]
Handler = Callable[[Any], None]


class Stepped(NamedTuple):
    """What came of one step."""

    listens: list[tuple[BusName, Sequence[Any] | None]]
    """Changes of interest; they hold before anything in `sent` arrives."""
    sent: list[tuple[BusName, Any]]
    next_ns: int | None


class Node(Protocol):
    def keys(self) -> dict[str, str]:
        """The keys of the device's points, each with its unit."""

    def get(self, key: str) -> Value:
        """ControlError for a key that isn't there."""

    def set(self, key: str, value: Value) -> None:
        """ControlError for a key that isn't there or can't be written, or a value that it can't take."""

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        """ControlError for a fault that the device can't take."""

    def clear_fault(self, number: int) -> None:
        """ControlError if there is no such fault."""

    def faults(self) -> Mapping[int, Mapping[str, Any]]: ...

    def stop(self) -> None: ...


class Post:
    """What nodes have to say when a step is over, in the order in which they reacted: who, at which bus, what."""

    def __init__(self) -> None:
        self.listens: list[tuple[str, BusName, Sequence[Any] | None]] = []
        self.sent: list[tuple[str, BusName, Any]] = []


class NodeLink:
    """An end of a bus under virtual time: keeps what is sent until the step is over."""

    __slots__ = ("_add", "_bus", "_handlers", "_name", "_post")

    def __init__(self, name: str, bus: BusName, post: Post, handlers: dict[BusName, Handler]) -> None:
        self._name, self._bus, self._post, self._handlers = name, bus, post, handlers
        self._add = post.sent.append

    def send(self, message: Any) -> None:
        self._add((self._name, self._bus, message))

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        self._handlers[self._bus] = handler
        self._post.listens.append((self._name, self._bus, interest))


class EventNode:
    """A clock and links that only move in steps; what reacts to them may be a device, or a test."""

    def __init__(self, name: str, now_ns: int = 0, post: Post | None = None) -> None:
        """`post` may be one for many."""
        self.name, self.post = name, post or Post()
        self.clock = VirtualClock(now_ns)
        self._links: dict[BusName, NodeLink] = {}
        self._handlers: dict[BusName, Handler] = {}

    def link(self, bus: BusName) -> NodeLink:
        """This node's end of `bus`; the same one at every call."""
        if bus not in self._links:
            self._links[bus] = NodeLink(self.name, bus, self.post, self._handlers)
        return self._links[bus]

    def react(self, until_ns: int, deliveries: Deliveries) -> int:
        """A step in one call, for who empties the post himself.  Returns the earliest wish, `NEVER_NS` without one."""
        clock, handlers = self.clock, self._handlers
        if deliveries:
            clock.instant_ns = until_ns
            for bus, message in deliveries:
                if bus in handlers:
                    handlers[bus](message)
        return clock.advance_to(until_ns)

    def finish(self) -> Stepped:
        """What has come of what it was handed, for who can't look into the post."""
        post = self.post
        listens = [(bus, interest) for _, bus, interest in post.listens]
        sent = [(bus, message) for _, bus, message in post.sent]
        post.listens.clear()
        post.sent.clear()
        return Stepped(listens, sent, self.clock.next_ns())


class LocalNode(EventNode):
    """A device in this process."""

    def __init__(self, entry: DeviceEntry, seed: int, store: Store, post: Post | None = None) -> None:
        super().__init__(entry.name, post=post)
        links: dict[str, Link[Any] | list[Link[Any]]] = {
            parameter: [self.link(bus) for bus in buses] if parameter in entry.many else self.link(buses[0])
            for parameter, buses in entry.links.items()
        }
        self.device: Device = build_device(entry, clock=self.clock, links=links, store=store, seed=seed)
        self.device.start()

    def keys(self) -> dict[str, str]:
        return {key: point.unit for key, point in self.device.points().items()}

    def get(self, key: str) -> Value:
        return read_point(self.device.points(), key)

    def set(self, key: str, value: Value) -> None:
        write_point(self.device.points(), key, value)

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        with refusals(self.name):
            return self.device.add_fault(fault)

    def clear_fault(self, number: int) -> None:
        with refusals(self.name):
            self.device.clear_fault(number)

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        return self.device.faults()

    def stop(self) -> None:
        self.device.stop()


def read_point(points: Mapping[str, Point], key: str) -> Value:
    return _point(points, key).read()


def write_point(points: Mapping[str, Point], key: str, value: Value) -> None:
    point = _point(points, key)
    if point.write is None:
        raise ControlError(f"{key} can only be read")
    try:
        point.write(value)
    except ValueError as cause:
        raise ControlError(f"{key} can't be {value!r}: {cause}") from cause


def _point(points: Mapping[str, Point], key: str) -> Point:
    try:
        return points[key]
    except KeyError:
        raise ControlError(f"there is no {key!r} here", "`fieldrig get DEVICE` lists the keys") from None
