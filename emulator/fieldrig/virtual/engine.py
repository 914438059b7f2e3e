"""Nodes and buses under one clock: the only scheduler of a rig in virtual time.

It moves to the earliest next instant of any node or bus.  There it delivers what arrives, in the order of the
configuration, lets the nodes react, passes on what they sent to the buses, and repeats until nothing is left at this
instant.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from random import Random
from typing import Any, Final

from fieldrig.bus import Bus, BusModel, Delivery, ModelBus
from fieldrig.clock import NEVER_NS, VirtualClock
from fieldrig.config.build import random_of
from fieldrig.config.rig_file import RigConfig
from fieldrig.device import Value
from fieldrig.errors import EndlessError, RigError
from fieldrig.faults.chance import reseed
from fieldrig.faults.disturbed import medium_of
from fieldrig.faults.note import FaultNote
from fieldrig.shortcuts import Shortcut
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.virtual.node import Deliveries, EventNode, LocalNode, Node, Outbox
from fieldrig.virtual.remote_node import RemoteNode

LONGEST_INSTANT = 10_000
"""Rounds of reactions at one instant after which the rig reports an endless exchange between devices."""

ALONE: Final = Shortcut("rig.alone", "the look at all members and buses while a single device acts")

ITSELF: Final = "fieldrig:rig"
"""The rig itself among the members that act, for faults; no device has a colon in its name."""

OnChange = Callable[[Value], None]
OnDelivery = Callable[[Bus[Any], Delivery[Any]], None]


class Engine:
    """The members of a rig, the instants at which they act, and the calls that hear of it."""

    def __init__(self, config: RigConfig) -> None:
        """RigError for a bus that has no model."""
        self.config = config
        self.now_ns = 0
        self.buses: dict[str, ModelBus[Any]] = {}
        self.models: dict[str, BusModel[Any]] = {}
        self._randoms: dict[str, Random] = {}
        """The random numbers of the buses."""
        for name, entry in config.buses.items():
            if not isinstance(entry.bus, ModelBus):
                raise RigError(f"{name}: {entry.kind} has no model to run under virtual time")
            self.buses[name] = entry.bus
            self.models[name] = medium_of(entry.bus)
            self._randoms[name] = random_of(name, config.seed)
            self.models[name].begin(0, self._randoms[name])
        self.nodes: dict[str, Node] = {}
        self.outside: dict[str, EventNode] = {}
        self.interests: dict[tuple[str, str], Any] = {}
        """The interest of each member in each bus."""
        self.clock = VirtualClock()
        """The clock of what the rig itself does, for faults and recordings."""
        self.listeners: tuple[OnDelivery, ...] = ()
        """Called with every delivery; another tuple after each change, which may come from one of them."""
        self.instant_calls: tuple[Callable[[], None], ...] = ()
        """Called at the end of every instant; another tuple after each change."""
        self.watches: dict[str, dict[str, list[OnChange]]] = {}
        """The calls for changes of points, by device and key."""
        self.is_playing = False
        """True while an instant is being played, between its first reaction and its last."""
        self.is_telling = False
        """True while one of the calls above is made."""
        self.earliest_ns = NEVER_NS
        """The earliest instant at which a member acts."""
        self._next_of: dict[str, int] = {}
        """The instant at which each member acts next, or `NEVER_NS`."""
        self._own_ns = NEVER_NS
        """The instant at which the rig itself acts next."""
        self._outbox = Outbox(self.buses)
        """The outbox of all nodes in this process."""
        self._here: dict[str, EventNode] = {}
        """The devices and outside members that react in this process."""
        self._elsewhere: dict[str, RemoteNode] = {}
        self._ends: list[Callable[[], None]] = []
        """Calls of recordings at the end of the present instant."""
        self._may_run_alone = ALONE.is_taken

    def build(self, stores: Mapping[str, Store]) -> None:
        """Build the devices, and let them act for the first time.  RigError for one that cannot be built."""
        for name, entry in self.config.devices.items():
            store = stores.get(name) or MemoryStore()
            if self.config.processes == "each":
                self.nodes[name] = self._elsewhere[name] = RemoteNode(entry, self.config.seed, store, self.buses)
            else:
                self.nodes[name] = self._here[name] = LocalNode(entry, self.config.seed, store, self._outbox)
            for bus in entry.buses:
                self.models[bus].join(name)
        self.step(self.nodes, {})

    def stop(self) -> None:
        """Stop every device; the last one started is the first to stop."""
        while self.nodes:
            self.nodes.popitem()[1].stop()

    def reseed(self, seed: int) -> None:
        """Draw from other random numbers from now on."""
        for name, random in self._randoms.items():
            reseed(random, f"{seed}/{name}")
        for node in self.nodes.values():
            node.reseed(seed)

    def add(self, member: str) -> EventNode:
        """Add a member from outside, which no bus knows yet."""
        node = self.outside[member] = self._here[member] = EventNode(member, self.now_ns, Outbox(self.buses))
        self._next_of[member] = NEVER_NS
        return node

    def remove(self, member: str) -> None:
        del self.outside[member], self._here[member], self._next_of[member]
        self.earliest_ns = min(self._next_of.values(), default=NEVER_NS)

    def plan(self) -> None:
        """Have the rig itself act at the next instant of its clock."""
        next_ns = self.clock.next_ns()
        self._own_ns = self._next_of[ITSELF] = NEVER_NS if next_ns is None else next_ns
        self.earliest_ns = min(self._next_of.values())

    def catch_up(self) -> None:
        """Bring the rig's own clock to the present instant; it stays behind while it has no events."""
        self.clock.instant_ns = max(self.clock.instant_ns, self.now_ns)

    def at_end_of(self, when_ns: int, action: Callable[[], None]) -> None:
        """Call `action` when everything has happened that happens at `when_ns`; it changes nothing."""
        self.catch_up()
        self.clock.call_at(when_ns, lambda: self._ends.append(action))
        self.plan()

    @contextmanager
    def present(self, device: str) -> Iterator[Node]:
        """Yield a device whose clock is at the present instant, then pass on what it does."""
        self.step([device], {})
        yield self.nodes[device]
        self.step([device], {})

    def switch(self, device: str, is_on: bool) -> None:
        """Switch a device off or on now."""
        for bus in self.config.devices[device].buses:
            if is_on:
                self.models[bus].join(device)
            else:
                self.models[bus].power_lost(self.now_ns, device)
        self.nodes[device].switch(self.now_ns, is_on)
        self.step([device], {})

    def note(self, device: str, note: FaultNote, instant_ns: int | None = None) -> None:
        """Add a fault of a device to the traces of its buses."""
        if not self.listeners:
            return
        delivery = Delivery(self.now_ns if instant_ns is None else instant_ns, device, note, ())
        for bus in self.config.devices[device].buses:
            if self.buses[bus].notes_faults:
                for listener in self.listeners:
                    listener(self.buses[bus], delivery)

    def arrival_ns(self) -> int:
        """Return the instant of the next arrival on any bus, or `NEVER_NS`."""
        earliest = NEVER_NS
        for model in self.models.values():
            arrival = model.next_ns()
            if arrival is not None and arrival < earliest:
                earliest = arrival
        return earliest

    def run_alone(self, until_ns: int) -> bool:
        """Let the only member that acts next go on until it sends something, or others have something to do.

        Nothing arrives up to `until_ns`.  Return false if it is not the only one.  Nothing differs from a `run_instant`
        for each of its instants, which would look at all members and buses each time.  A member from outside is no such
        member, as it has an outbox of its own; but it may be there, because nothing arrives at it meanwhile.
        """
        if not self._may_run_alone or self.instant_calls:
            return False
        name, next_ns, limit_ns = "", NEVER_NS, until_ns + 1
        for member, at_ns in self._next_of.items():
            if at_ns < next_ns:
                name, next_ns, limit_ns = member, at_ns, min(next_ns, limit_ns)
            elif at_ns < limit_ns:
                limit_ns = at_ns
        if not self.now_ns <= next_ns < limit_ns or name not in self._here or name in self.watches:
            return False
        if name in self.outside:
            return False
        react, outbox = self._here[name].react, self._outbox
        while next_ns < limit_ns and not outbox.sent and not outbox.listens:
            self.now_ns = next_ns
            next_ns = react(next_ns, ())
        self._next_of[name] = next_ns
        self.earliest_ns = min(self._next_of.values())
        self._hand_in()
        return True

    def run_instant(self, now_ns: int) -> None:
        """Let everything happen that happens at this instant.  EndlessError if it has no end."""
        self.is_playing = True
        try:
            self._play_instant(now_ns)
            if self._ends:
                ends, self._ends = self._ends, []
                for end in ends:
                    end()
        finally:
            self.is_playing = False
        for call in self.instant_calls:
            with self._telling():
                call()

    def take_from_outside(self) -> None:
        """Take what members from outside sent or set between instants."""
        if self.outside:
            has_news, next_of = not self._outbox.is_empty, self._next_of
            for name, node in self.outside.items():
                next_ns = node.clock.next_ns()
                if next_ns is None:
                    next_ns = NEVER_NS
                if next_ns != next_of[name]:
                    next_of[name], has_news = next_ns, True
                if not node.outbox.is_empty:
                    self._gather(node.outbox)
                    has_news = True
            if has_news:
                self.earliest_ns = min(next_of.values())
                self._hand_in()

    def step(self, names: Collection[str], inbox: Mapping[str, Deliveries]) -> None:
        """Let the members react now; those in processes of their own work at the same time as those here."""
        here, next_of, deliveries_to, now_ns = self._here, self._next_of, inbox.get, self.now_ns
        elsewhere = [name for name in names if name in self._elsewhere] if self._elsewhere else ()
        for name in elsewhere:
            self._elsewhere[name].begin(now_ns, deliveries_to(name, ()))
        for name in [name for name in names if name in here] if elsewhere else names:
            next_of[name] = here[name].react(now_ns, deliveries_to(name, ()))
        self._fetch(elsewhere)
        self.earliest_ns = min(next_of.values(), default=NEVER_NS)
        if self.outside:
            for name in names:
                if name in self.outside:
                    self._gather(self.outside[name].outbox)
        self._hand_in()
        if self.watches:
            self._tell(names)

    def _play_instant(self, now_ns: int) -> None:
        self.now_ns = now_ns
        inbox = self._arrivals()
        active = self._active(inbox)
        for _ in range(LONGEST_INSTANT):
            if not active:
                return
            self.step(active, inbox)
            inbox = self._arrivals()
            if not inbox and self.earliest_ns > now_ns:
                return
            active = self._active(inbox)
        raise EndlessError(
            f"at {now_ns} ns {', '.join(sorted(inbox))} react to each other endlessly without time passing",
            "give one of them a turnaround time, or the bus a bit rate",
        )

    def _active(self, inbox: Mapping[str, Deliveries]) -> Collection[str]:
        """Return the members that act at this instant, in the order of the configuration, which `_next_of` has."""
        now_ns = self.now_ns
        if len(inbox) == 1 and self.earliest_ns > now_ns:
            return inbox
        if self._own_ns <= now_ns:
            self.clock.advance_to(now_ns)
            self.plan()
        return [name for name, next_ns in self._next_of.items() if name in inbox or next_ns <= now_ns]

    def _arrivals(self) -> dict[str, Deliveries]:
        """Return what each member receives, in the order of the buses."""
        now_ns = self.now_ns
        inbox: dict[str, Deliveries] = {}
        for bus, model in self.models.items():
            arrival_ns = model.next_ns()
            if arrival_ns is None or arrival_ns > now_ns:
                continue
            for delivery in model.collect(now_ns):
                for listener in self.listeners:
                    listener(self.buses[bus], delivery)
                arrived = ((bus, delivery.message),)  # the same for all, for they may be many
                if not inbox:
                    inbox = dict.fromkeys(delivery.receivers, arrived)
                    continue
                for receiver in delivery.receivers:
                    inbox[receiver] = (*inbox[receiver], *arrived) if receiver in inbox else arrived
        return inbox

    def _fetch(self, names: Iterable[str]) -> None:
        """Take the results of nodes in other processes."""
        outbox = self._outbox
        for name in names:
            stepped = self._elsewhere[name].finish()
            self._next_of[name] = NEVER_NS if stepped.next_ns is None else stepped.next_ns
            outbox.listens += [(name, bus, interest) for bus, interest in stepped.listens]
            outbox.sent += [(name, bus, message) for bus, message in stepped.sent]
            outbox.notes += [(name, instant_ns, note) for instant_ns, note in stepped.notes]

    def _gather(self, outbox: Outbox) -> None:
        """Append the outbox of a member from outside, after all others."""
        self._outbox.listens += outbox.listens
        self._outbox.sent += outbox.sent
        outbox.listens.clear()
        outbox.sent.clear()

    def _hand_in(self) -> None:
        """Pass everything to the buses: changes of interest first, then messages."""
        models, outbox, now_ns = self.models, self._outbox, self.now_ns
        if outbox.notes:
            for device, instant_ns, note in outbox.notes:
                self.note(device, note, instant_ns)
            outbox.notes.clear()
        if outbox.listens:
            for name, bus, interest in outbox.listens:
                self.interests[name, bus] = interest
                models[bus].listen(now_ns, name, interest)
            outbox.listens.clear()
        last = None
        for name, bus, message in outbox.sent:
            if bus != last:
                last, submit = bus, models[bus].submit
            submit(now_ns, name, message)
        outbox.sent.clear()

    def _tell(self, names: Iterable[str]) -> None:
        """Tell the changes of watched points of these devices."""
        for name in [name for name in names if name in self.watches]:
            for key, value in self.nodes[name].changes():
                for call in list(self.watches[name].get(key, ())):
                    with self._telling():
                        call(value)

    @contextmanager
    def _telling(self) -> Iterator[None]:
        was_telling, self.is_telling = self.is_telling, True
        try:
            yield
        finally:
            self.is_telling = was_telling
