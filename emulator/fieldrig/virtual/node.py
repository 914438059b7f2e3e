"""One device under virtual time, advanced in steps.

A step takes an instant and the messages that arrive; its results are the messages that the device sends and the instant
of its next action.  A node is local, or remote in a process of its own (`remote_node`), with the same result.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple, Protocol, TypeVar

from fieldrig.bus import Bus
from fieldrig.clock import VirtualClock
from fieldrig.config.build import build_device, random_of
from fieldrig.config.entries import DeviceEntry
from fieldrig.device import Device, Value
from fieldrig.errors import ControlError, RigError, refusals
from fieldrig.faults.chance import reseed
from fieldrig.faults.note import FaultNote
from fieldrig.faults.noted import Noted
from fieldrig.hub.checked_link import uninteresting, unsendable
from fieldrig.link import Link
from fieldrig.points.access import points_for, read_point, read_points, write_point
from fieldrig.points.facts import facts_of
from fieldrig.points.hooks import Hook
from fieldrig.points.watched_points import Change, WatchedPoints
from fieldrig.storage.store import Store
from fieldrig.text.exception_notes import blame, blamed
from fieldrig.text.nearest import closest

T = TypeVar("T")
BusName = str
Deliveries = Sequence[tuple[BusName, Any]]
Handler = Callable[[Any], None]


class Stepped(NamedTuple):
    """The results of one step."""

    listens: list[tuple[BusName, Sequence[Any] | None]]
    """Changes of interest; they hold before anything in `sent` arrives."""
    sent: list[tuple[BusName, Any]]
    next_ns: int | None
    notes: list[tuple[int, FaultNote]]
    """The faults of the device for the traces of its buses, with their instants."""


class Node(Protocol):
    def keys(self) -> dict[str, str]:
        """Return the keys of the device's points, each with its unit."""

    def facts(self) -> dict[str, dict[str, Any]]:
        """Return unit, description and other facts of each point, by key."""

    def values(self, now_ns: int, keys: Iterable[str] | None = None) -> dict[str, Value]:
        """Return the values of these points at `now_ns`; None stands for all.  ControlError for an unknown key."""

    def front(self, now_ns: int) -> dict[str, Any]:
        """Return the device's front in values that JSON has."""

    def get(self, now_ns: int, key: str) -> Value:
        """Return the value of a point at `now_ns`, up to which everything has happened.

        ControlError for an unknown key.
        """

    def set(self, key: str, value: Value) -> None:
        """Write a point.  ControlError for an unknown or read-only key, or a value that it refuses."""

    def answer(self, question: str, message: Any) -> Any:
        """Answer a question of this kind of device.  ControlError if the device refuses."""

    def add_fault(self, fault: Mapping[str, Any], above: int = 0) -> int:
        """Add a fault, and return its number, which is above `above`.  ControlError for one that the device refuses."""

    def begin_fault(self, number: int) -> None:
        """Begin a fault that waits for its condition, which is met now."""

    def clear_fault(self, number: int) -> None:
        """Remove a fault.  ControlError if there is none of this number."""

    def faults(self, now_ns: int) -> Mapping[int, Mapping[str, Any]]:
        """Return the faults of the device, as they are at `now_ns`."""

    def watch(self, now_ns: int, key: str) -> None:
        """Watch a point from `now_ns` on.  ControlError for an unknown key."""

    def unwatch(self, key: str) -> None:
        """End the watch of a point."""

    def changes(self) -> list[Change]:
        """Return the changes of watched points since the last call, in their order."""

    def switch(self, now_ns: int, is_on: bool) -> None:
        """Switch the power off or on.  The caller steps the node at `now_ns` afterwards."""

    def reseed(self, seed: int) -> None:
        """Draw from other random numbers from now on, also after the next power cycle."""

    def stop(self) -> None: ...


class Outbox:
    """Everything that nodes have to pass on after a step, in the order of their reactions: device, bus, and content."""

    def __init__(self, buses: Mapping[BusName, Bus[Any]] | None = None) -> None:
        """`buses` check what is sent; None where there are none, as in a test of a single device."""
        self.buses = buses
        self.listens: list[tuple[str, BusName, Sequence[Any] | None]] = []
        self.sent: list[tuple[str, BusName, Any]] = []
        self.notes: list[tuple[str, int, FaultNote]] = []
        """The faults of devices for the traces of their buses, with their instants."""

    @property
    def is_empty(self) -> bool:
        return not (self.sent or self.listens or self.notes)


class NodeLink:
    """An end of a bus under virtual time that keeps what is sent until the step is over."""

    __slots__ = ("_add", "_bus", "_check", "_check_interest", "_handlers", "_name", "_outbox")

    def __init__(self, name: str, bus: BusName, outbox: Outbox, handlers: dict[BusName, Handler]) -> None:
        self._name, self._bus, self._outbox, self._handlers = name, bus, outbox, handlers
        self._add = outbox.sent.append
        known = None if outbox.buses is None else outbox.buses.get(bus)
        self._check: Callable[[Any], None] = _anything if known is None else known.check
        self._check_interest: Callable[[Any], None] = _anything if known is None else known.check_interest

    def send(self, message: Any) -> None:
        try:
            self._check(message)
        except (TypeError, ValueError) as cause:
            raise unsendable(cause, self._name, self._bus, message) from cause
        self._add((self._name, self._bus, message))

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        try:
            self._check_interest(interest)
        except (TypeError, ValueError) as cause:
            raise uninteresting(cause, self._name, self._bus, interest) from cause
        self._handlers[self._bus] = handler
        self._outbox.listens.append((self._name, self._bus, interest))


def _anything(_: Any) -> None:
    """Accept anything, in the test of a single device."""


class EventNode:
    """A clock and links that only move in steps, for a device or for a test."""

    def __init__(self, name: str, now_ns: int = 0, outbox: Outbox | None = None) -> None:
        """`outbox` may be shared by many nodes; it knows the buses."""
        self.name, self.outbox = name, outbox or Outbox()
        self.clock = VirtualClock(now_ns)
        self._links: dict[BusName, NodeLink] = {}
        self._handlers: dict[BusName, Handler] = {}

    def link(self, bus: BusName) -> NodeLink:
        """Return this node's end of `bus`, always the same one.  RigError for a bus that the rig doesn't have."""
        if bus not in self._links:
            buses = self.outbox.buses
            if buses is not None and bus not in buses:
                raise RigError(f"the rig has no bus {bus!r}", closest(bus, list(buses)))
            self._links[bus] = NodeLink(self.name, bus, self.outbox, self._handlers)
        return self._links[bus]

    def react(self, until_ns: int, deliveries: Deliveries) -> int:
        """Do a step in one call, and return the instant of the next action, or `NEVER_NS`.

        The caller drains the outbox.
        """
        clock, handlers, at = self.clock, self._handlers, None
        try:
            if deliveries:
                clock.instant_ns = until_ns
                for at, message in deliveries:
                    if at in handlers:
                        handlers[at](message)
                at = None
            return clock.advance_to(until_ns)
        except Exception as fault:
            blame(fault, self.name, at, clock.instant_ns)
            raise

    def finish(self) -> Stepped:
        """Return the results of a step, for callers that cannot read the outbox."""
        outbox = self.outbox
        listens = [(bus, interest) for _, bus, interest in outbox.listens]
        sent = [(bus, message) for _, bus, message in outbox.sent]
        outbox.listens.clear()
        notes = [(now_ns, note) for _, now_ns, note in outbox.notes]
        outbox.sent.clear()
        outbox.notes.clear()
        return Stepped(listens, sent, self.clock.next_ns(), notes)


class LocalNode(EventNode):
    """A device in this process."""

    def __init__(self, entry: DeviceEntry, seed: int, store: Store, outbox: Outbox | None = None) -> None:
        super().__init__(entry.name, outbox=outbox)
        self._entry, self._seed, self._store = entry, seed, store
        self._random = random_of(entry.name, seed)
        self.is_on = True
        self._noted = Noted(self._note)
        with blamed(self.name, 0):
            self.device = self._built()
            self._noted.follow(self.device.injected, self.clock)
            self.device.start()
        self._watched = WatchedPoints(self.device)
        self.cycle_hook = Hook("end_of_cycle", self.device)

    def switch(self, now_ns: int, is_on: bool) -> None:
        """Switch the power off or on.  A device without power has no timers, hears nothing, and keeps its store."""
        self.clock = VirtualClock(now_ns)
        self._handlers.clear()
        self.is_on = is_on
        if not is_on:
            return
        with blamed(self.name, now_ns):
            self._random = random_of(self.name, self._seed)
            former, self.device = self.device, self._built()
            if former.injected is not None and self.device.injected is not None:
                self.device.injected.adopt(former.injected)
            self._noted.follow(self.device.injected, self.clock)
            self._watched.move_to(self.device)
            self.cycle_hook.move_to(self.device)
            self.device.start()

    def reseed(self, seed: int) -> None:
        """Draw from other random numbers from now on, also after the next power cycle."""
        self._seed = seed
        reseed(self._random, f"{seed}/{self.name}")

    def _note(self, note: FaultNote) -> None:
        self.outbox.notes.append((self.name, self.clock.now_ns(), note))

    def _built(self) -> Device:
        entry = self._entry
        links: dict[str, Link[Any] | list[Link[Any]]] = {
            parameter: [self.link(bus) for bus in buses] if parameter in entry.many else self.link(buses[0])
            for parameter, buses in entry.links.items()
        }
        return build_device(entry, clock=self.clock, links=links, store=self._store, random=self._random)

    def _check_on(self) -> None:
        if not self.is_on:
            raise ControlError(f"{self.name} is switched off", "it answers when the fault that did it ends")

    def keys(self) -> dict[str, str]:
        return {key: point.unit for key, point in self.device.points().items()}

    def look(self, now_ns: int, read: Callable[[Device], T]) -> T:
        """Return what `read` finds at the device at `now_ns`."""
        self._check_on()
        self.look_at(now_ns)
        with blamed(self.name, now_ns):
            return read(self.device)

    def facts(self) -> dict[str, dict[str, Any]]:
        return facts_of(self.device.points())

    def values(self, now_ns: int, keys: Iterable[str] | None = None) -> dict[str, Value]:
        chosen = None if keys is None else list(keys)
        return self.look(now_ns, lambda device: read_points(self.name, points_for(device, chosen or ()), chosen))

    def front(self, now_ns: int) -> dict[str, Any]:
        self.look_at(now_ns)
        with blamed(self.name, now_ns):
            return self.device.front_words()

    def get(self, now_ns: int, key: str) -> Value:
        return self.look(now_ns, lambda device: read_point(self.name, points_for(device, (key,)), key))

    def set(self, key: str, value: Value) -> None:
        self._check_on()
        with blamed(self.name, self.clock.now_ns()):
            write_point(self.name, points_for(self.device, (key,)), key, value)

    def answer(self, question: str, message: Any) -> Any:
        self._check_on()
        with refusals(self.name):
            return self.device.answer(question, message)

    @contextmanager
    def _powerless(self) -> Iterator[None]:
        """Keep what a device without power does with its links from them: a fault may change what it listens to."""
        outbox = self.outbox
        listens, sent = len(outbox.listens), len(outbox.sent)
        try:
            yield
        finally:
            if not self.is_on:
                del outbox.listens[listens:], outbox.sent[sent:]
                self._handlers.clear()

    def add_fault(self, fault: Mapping[str, Any], above: int = 0) -> int:
        with refusals(self.name), self._powerless():
            if self.device.injected is not None:
                self.device.injected.records.reserve(above)
            return self.device.add_fault(fault)

    def begin_fault(self, number: int) -> None:
        if self.device.injected is not None:
            with self._powerless():
                self.device.injected.begin(number)

    def clear_fault(self, number: int) -> None:
        with refusals(self.name), self._powerless():
            self.device.clear_fault(number)

    def faults(self, now_ns: int) -> Mapping[int, Mapping[str, Any]]:
        self.look_at(now_ns)
        return self.device.faults()

    def watch(self, now_ns: int, key: str) -> None:
        self.get(now_ns, key)
        self._watched.watch(key)

    def unwatch(self, key: str) -> None:
        self._watched.unwatch(key)

    def changes(self) -> list[Change]:
        if not self.is_on:
            return []
        with blamed(self.name, self.clock.now_ns()):
            return self._watched.take()

    def look_at(self, now_ns: int) -> None:
        """Show the device the present instant.  The clock of a node without events stays behind until it is needed."""
        self.clock.instant_ns = max(self.clock.instant_ns, now_ns)

    def stop(self) -> None:
        self.device.stop()
