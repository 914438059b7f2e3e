"""Nodes, buses and one clock from one configuration, under virtual time.

The rig is the only scheduler.  It moves to the earliest next instant of any node or bus.  There it delivers what
arrives, in the order of the configuration, lets the nodes react, passes on what they sent to the buses, and repeats
until nothing is left at this instant.  The same seed gives the same bytes on every bus, with all nodes in this process
or each in its own.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from random import Random
from types import TracebackType
from typing import TYPE_CHECKING, Any, Concatenate, Final, ParamSpec, Self, TypeVar, overload

from fieldrig.bus import Bus, BusModel, Delivery, Doors, ModelBus
from fieldrig.clock import NEVER_NS, VirtualClock, whole_ns
from fieldrig.config.build import random_of
from fieldrig.config.rig_file import RigConfig
from fieldrig.device import Value
from fieldrig.errors import ArgumentError, ControlError, RigError, refusals
from fieldrig.faults.chance import reseed
from fieldrig.faults.condition import condition_of
from fieldrig.faults.disturbed import medium_of
from fieldrig.faults.faults import Timed, fault_of
from fieldrig.faults.mains import Mains
from fieldrig.faults.note import FaultNote
from fieldrig.faults.power import MODELS, loses_power
from fieldrig.faults.triggers import Triggers
from fieldrig.outside.untrusted import shown
from fieldrig.points.names import split_point, written_point
from fieldrig.recording.signals import Rhythm, wish_of
from fieldrig.shortcuts import Shortcut
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.system.threads import threads
from fieldrig.text.nearest import closest
from fieldrig.virtual.branch import Branch, branch_of, check_may_branch
from fieldrig.virtual.branches import check_seed, run_branches
from fieldrig.virtual.checkpoints import Checkpoints
from fieldrig.virtual.node import Deliveries, EventNode, LocalNode, Node, Outbox
from fieldrig.virtual.readings import Readings, seconds
from fieldrig.virtual.remote_node import RemoteNode
from fieldrig.virtual.trace_hash import TraceHash
from fieldrig.virtual.until import duration, run_until_met, run_while_met

if TYPE_CHECKING:
    from fieldrig.recording.recording import Recording

LONGEST_INSTANT = 10_000
"""Rounds of reactions at one instant after which the rig reports an endless exchange between devices."""

ALONE: Final = Shortcut("rig.alone", "the look at all members and buses while a single device acts")

RIG: Final = "fieldrig:rig"
"""The rig itself among the members that act, for faults; no device has a colon in its name."""
UNREPEATED: Final = "what a member sends between two runs cannot be repeated; use set, answer and faults"

T = TypeVar("T")
P = ParamSpec("P")
C = TypeVar("C")
OnChange = Callable[[Value], None]
OnDelivery = Callable[[Bus[Any], Delivery[Any]], None]


class Rig:
    """A rig under virtual time.  Close it, or use it in a `with` statement, to end nodes in processes of their own."""

    def __init__(
        self, config: RigConfig, on_delivery: OnDelivery | None = None, stores: Mapping[str, Store] | None = None
    ) -> None:
        """RigError if a device cannot be built.  `stores` are the memories of devices, by name, over a power cycle."""
        if not isinstance(config, RigConfig):
            raise ArgumentError(f"a rig cannot be made of {shown(config)}", 'write Rig(load("rig.yaml"))')
        for name in stores or {}:
            if name not in config.devices:
                raise ControlError(f"the rig has no device {name!r}", closest(name, list(config.devices)))
        self.config = config
        self._is_closed = False
        self._may_run_alone = ALONE.is_taken
        self.now_ns = 0
        self.buses: dict[str, ModelBus[Any]] = {}
        self._models: dict[str, BusModel[Any]] = {}
        self._randoms: dict[str, Random] = {}
        """The random numbers of the buses."""
        for name, bus_entry in config.buses.items():
            if not isinstance(bus_entry.bus, ModelBus):
                raise RigError(f"{name}: {bus_entry.kind} has no model to run under virtual time")
            self.buses[name] = bus_entry.bus
            self._models[name] = medium_of(bus_entry.bus)
            self._randoms[name] = random_of(name, config.seed)
            self._models[name].begin(0, self._randoms[name])
        self._nodes: dict[str, Node] = {}
        self._interests: dict[tuple[str, str], Any] = {}
        """The interest of each member in each bus."""
        self._outbox = Outbox(self.buses)
        """The outbox of all nodes in this process."""
        self._outside: dict[str, EventNode] = {}
        self.clients = Clients(self)
        """The clients of ports, in a block of `virtual_time`."""
        self._here: dict[str, EventNode] = {}
        """The devices and outside members that react in this process."""
        self._elsewhere: dict[str, RemoteNode] = {}
        self._next_of: dict[str, int] = {}
        """The instant at which each member acts next, or `NEVER_NS`."""
        self._earliest_ns = NEVER_NS
        """The earliest of these instants."""
        self._own_clock = VirtualClock()
        self._own_ns = NEVER_NS
        """The instant at which the rig itself acts next, for a fault."""
        self._triggers = Triggers(self._own_clock, self, self._begin_fault, self._plan)
        self._mains: Mains | None = None
        """The power of the devices, once it has been switched."""
        self._listeners: tuple[OnDelivery, ...] = () if on_delivery is None else (on_delivery,)
        """Called with every delivery; another tuple after each change, which may come from one of them."""
        self._ends: list[Callable[[], None]] = []
        """Calls of recordings at the end of the present instant."""
        self._instant_calls: tuple[Callable[[], None], ...] = ()
        """Called at the end of every instant; another tuple after each change."""
        self._is_playing = False
        """True while an instant is being played, between its first reaction and its last."""
        self._watches: dict[str, dict[str, list[OnChange]]] = {}
        """The calls for changes of points, by device and key."""
        self._is_telling = False
        """True while such a call is made."""
        self._stores = dict(stores or {})
        self._threads = threads()
        """The threads that are older than the rig."""
        self.is_branch = False
        """True in a branch, where the calls of `on_delivery`, `on_change` and `on_instant` are made as well."""
        self._branches: list[Branch] = []
        self._checkpoints: Checkpoints | None = None
        self._park_ns = NEVER_NS
        """The instant of the next checkpoint, or `NEVER_NS`."""
        self._trace_hash: TraceHash | None = None
        self._readings: Readings | None = None
        """The record of points that are read, while a condition is looked at."""
        try:
            self._build(stores or {})
        except BaseException:
            self.close()
            raise

    def next_ns(self) -> int | None:
        """Return the instant at which something happens next; None if nothing ever will."""
        self._check_open()
        self._take_from_outside()
        earliest = min(self._earliest_ns, self._arrival_ns())
        return None if earliest == NEVER_NS else max(earliest, self.now_ns)

    def step(self) -> bool:
        """Go to the next instant at which something happens, and let it happen.  False if nothing ever will."""
        self._check_may_run()
        next_ns = self.next_ns()
        if next_ns is not None:
            self._park(next_ns)
            self._run_instant(next_ns)
        return next_ns is not None

    def run_until(self, until_ns: int, stop: Callable[[], object] | None = None) -> bool:
        """Let everything happen up to and including `until_ns`, and return true; or stop before that.

        `stop()` is called after each instant at which a message arrives or a member from outside acts.  If it returns
        true, the rig stays at that instant and False is returned.  For a condition on values, use `until`.
        ArgumentError for anything but whole nanoseconds, and for an instant that has passed.
        """
        self._check_may_run()
        until_ns, is_reached = self._instant(until_ns), True
        if stop is not None and not callable(stop):
            raise ArgumentError(f"run_until cannot call {shown(stop)}", "expected a function without arguments")
        while is_reached:
            self._check_open()
            self._take_from_outside()
            arrival_ns = self._arrival_ns()
            next_ns = max(min(self._earliest_ns, arrival_ns), self.now_ns)
            if next_ns > until_ns or next_ns == NEVER_NS:
                break
            self._park(next_ns)
            if self._earliest_ns >= arrival_ns or not self._run_alone(min(until_ns, self._park_ns, arrival_ns - 1)):
                self._run_instant(next_ns)
                is_reached = stop is None or not stop()
        if is_reached:
            self._park(until_ns + 1)
            self.now_ns = max(self.now_ns, until_ns)
        for node in self._outside.values():
            node.clock.instant_ns = self.now_ns
        return is_reached

    def run_for(self, duration_ns: int) -> None:
        """Let everything happen that happens in the next `duration_ns`, such as `10 * MS`."""
        self.run_until(self.now_ns + duration(duration_ns, "run_for"))

    def until(self, condition: Callable[[], T], within: int) -> T:
        """Run until `condition()` is true, at most for `within` nanoseconds, and return what it returned.

        It is called now, after each instant at which something happens, and at least once in a millisecond.
        UnmetError, with the points that it read and their last changes, if it is never true.
        """
        return run_until_met(self, condition, within, lambda readings: self._looked_at(condition, readings))

    def stays(self, condition: Callable[[], object], during: int, until: Callable[[], object] | None = None) -> None:
        """Run for `during` nanoseconds, or until `until()` is true, in which `condition()` has to stay true.

        It is called as by `until`.  UnmetError at the first instant at which it is not true, and if the end that is
        given by `until` does not come in time.
        """
        run_while_met(self, condition, during, self._looked_at, until)

    def never(self, condition: Callable[[], object], during: int) -> None:
        """Run for `during` nanoseconds, at no instant of which `condition()` may be true.  UnmetError if it is."""
        run_while_met(self, condition, during, self._looked_at, is_wanted=False)

    def attach(self, member: str) -> EventNode:
        """Add a member from outside, such as a test, with a `clock` and a `link(bus)` to any bus of the rig."""
        self._check_open()
        if not isinstance(member, str) or not member:
            raise ArgumentError(f"a member cannot be called {shown(member)}", 'expected a name, such as "master"')
        if member in self._nodes or member in self._outside:
            raise RigError(f"the rig already has a member {member!r}", "choose another name")
        node = self._add(member)
        for model in self._models.values():
            model.join(member)
        return node

    def detach(self, member: str) -> None:
        """Remove a member that was attached, with its timers and with what it has sent and waits for its bus."""
        self._check_open()
        if not isinstance(member, str) or member not in self._outside:
            raise RigError(f"{shown(member)} is not attached", closest(str(member), list(self._outside)))
        self._take_from_outside()
        self._remove(member)
        for model in self._models.values():
            model.leave(member)

    def keys(self, device: str) -> dict[str, str]:
        """Return the keys of a device's points, each with its unit."""
        return self._node(device).keys()

    def facts(self, device: str) -> dict[str, dict[str, Any]]:
        """Return unit, description and other facts of each point of a device, by key."""
        return self._node(device).facts()

    def values(self, device: str, keys: Iterable[str] | None = None) -> dict[str, Value]:
        """Return the values of these points of a device at the present instant; None stands for all of them."""
        return self._node(device).values(self.now_ns, keys)

    def front(self, device: str) -> dict[str, Any]:
        """Return what a person sees and operates in front of a device, as its groups of parts and their points."""
        return self._node(device).front(self.now_ns)

    def get(self, point: str, key: str | None = None) -> Value:
        """Return the value of a point at the present instant: `get("tank/level")`, or `get("tank", "level")`.

        Reading is not an event and changes nothing that follows.
        """
        device, key = split_point(point, key)
        value = self._node(device).get(self.now_ns, key)
        if self._readings is not None:
            self._readings.note(device, key, self.now_ns, value)
        return value

    @overload
    def set(self, point: str, value: Value, /) -> None: ...

    @overload
    def set(self, device: str, key: str, value: Value, /) -> None: ...

    def set(self, point: str, *key_and_value: Value) -> None:
        """Write a point at the present instant: `set("tank/level", 1.25)`, or `set("tank", "level", 1.25)`."""
        device, key, value = written_point(point, *key_and_value)
        self._asked("set", device, key, value)
        with self._present(device) as node:
            node.set(key, value)

    def on_change(self, point: str, call: OnChange) -> Callable[[], None]:
        """Call `call(value)` at each change of a point from now on; `now_ns` is the instant of the change.

        The device is looked at after each of its reactions, and a card that runs a program also between its
        instructions.  `call` may read and write points, but not run the rig.  Returns a function that ends the watch.
        """
        device, key = split_point(point)
        node = self._node(device)
        if not callable(call):
            raise ArgumentError(f"on_change cannot call {shown(call)}", "expected a function that takes the value")
        if not self._watches.get(device, {}).get(key):
            node.watch(self.now_ns, key)
        calls = self._watches.setdefault(device, {}).setdefault(key, [])
        calls.append(call)
        self._changed_for_good()

        def end() -> None:
            if call in calls:
                calls.remove(call)
                if not calls and not self._is_closed:
                    node.unwatch(key)

        return end

    def on_delivery(self, call: OnDelivery) -> Callable[[], None]:
        """Call `call(bus, delivery)` with every message from now on; returns a function that ends it.

        Faults that a bus notes in its traces are among them.  `call` may not run the rig.
        """
        self._check_open()
        if not callable(call):
            raise ArgumentError(
                f"on_delivery cannot call {shown(call)}", "expected a function that takes a bus and a delivery"
            )
        self._listeners = (*self._listeners, call)
        self._changed_for_good()

        def end() -> None:
            self._listeners = _without(self._listeners, call)

        return end

    def on_instant(self, call: Callable[[], None]) -> Callable[[], None]:
        """Call `call()` at the end of each instant at which something happens; returns a function that ends it.

        Everything has happened then that happens at `now_ns`.  `call` may read and write points, but not run the rig.
        """
        self._check_open()
        if not callable(call):
            raise ArgumentError(f"on_instant cannot call {shown(call)}", "expected a function without arguments")
        self._instant_calls = (*self._instant_calls, call)
        self._changed_for_good()

        def end() -> None:
            self._instant_calls = _without(self._instant_calls, call)

        return end

    def record(self, signals: str | Sequence[str], rhythm: Rhythm = "cycle") -> "Recording":
        """Record signals from now on: points of devices (`tank/level`) and wires of a bus (`wires/lamp.on`).

        `rhythm` says when.  "cycle": at the end of each cycle of the device, once in a millisecond if it has none, and
        wires at each change.  "change": each change of all signals, also of pulses shorter than any period.  A number:
        a period in nanoseconds, such as `10 * MS`.  Recording is no event, so the trace stays the same.
        ControlError, with the nearest name, for a signal that does not exist.
        """
        from fieldrig.recording.recording import LocalRecording  # only those who record need its formats
        from fieldrig.virtual.recorded import RigSource

        self._check_open()
        return LocalRecording(RigSource(self), *wish_of(signals, rhythm))

    def answer(self, device: str, question: str, message: Any) -> Any:
        """Return the answer of a device to a question of its kind.  ControlError if the device refuses."""
        self._asked("answer", device, question, message)
        with self._present(device) as node:
            return node.answer(question, message)

    def statistics(self, bus: str) -> dict[str, float]:
        """Return frames, load and other figures of a bus, by name.  ControlError if there is no such bus."""
        return self._model(bus).statistics(self.now_ns)

    def signals(self, bus: str) -> dict[str, dict[str, Any]]:
        """Return the facts of each signal of a bus that has a value, such as a wire, by its name."""
        standing = self._model(bus).standing()
        return self.buses[bus].signals(standing, self.now_ns)

    def interests(self, bus: str) -> dict[str, Any]:
        """Return the interest of each member of a bus: names of wires, unit ids or filters; None for everything."""
        self._model(bus)
        return {name: interest for (name, known), interest in self._interests.items() if known == bus}

    def conditions(self, bus: str) -> Mapping[str, str]:
        """Return the states of a bus that are reported to a person, by a name of their own."""
        return self._model(bus).conditions(self.now_ns)

    def add_fault(self, where: str, fault: Mapping[str, Any]) -> int:
        """Add a fault of a bus or a device from now on, and return its number.

        ControlError for one that it refuses.
        """
        self._check_part(where)
        if not isinstance(fault, Mapping):
            raise ArgumentError(f"a fault cannot be {shown(fault)}", 'expected a mapping, such as {"what": "drop"}')
        self._asked("add_fault", where, fault)
        if where in self._models:
            with refusals(where):
                number = self._models[where].add_fault(self.now_ns, fault)
        elif loses_power(self.config.devices[where].cls, fault):
            with refusals(where):
                number = self._lose_power(where, fault_of(fault, MODELS))
        else:
            with self._present(where) as node:
                number = node.add_fault(fault, 0 if self._mains is None else self._mains.given(where))
        self._arm(where, number)
        return number

    def restart(self, device: str) -> None:
        """Switch a device off and on again at the present instant; it keeps its non-volatile memory and its faults."""
        self._node(device)
        self._asked("restart", device)
        if self._mains is not None and self._mains.is_off(device):
            raise ControlError(f"{device} is switched off", "clear the fault that has switched it off")
        self._switch(device, False)
        self._switch(device, True)

    def clear_fault(self, where: str, number: int) -> None:
        """Remove a fault of a bus or a device.  ControlError if there is none of this number."""
        self._check_part(where)
        if type(number) is not int:
            raise ArgumentError(f"a fault cannot have the number {shown(number)}", "expected what add_fault returned")
        self._asked("clear_fault", where, number)
        self._triggers.forget(where, number)
        if where in self._models:
            with refusals(where):
                self._models[where].clear_fault(self.now_ns, number)
            return
        if self._mains is not None and self._mains.has(where, number):
            self._mains.clear(self.now_ns, where, number)
            return
        with self._present(where) as node:
            node.clear_fault(number)

    def faults(self, where: str) -> Mapping[int, Mapping[str, Any]]:
        """Return the faults of a bus or a device that were added and not cleared, by number."""
        self._check_part(where)
        if where in self._models:
            return self._models[where].all_faults(self.now_ns)
        own = self._node(where).faults(self.now_ns)
        return own if self._mains is None else dict(sorted({**own, **self._mains.about(self.now_ns, where)}.items()))

    def trace_hash(self) -> str:
        """Return the number of all messages since the first call of this function, and a hash of them.

        Two rigs that did the same have the same hash; it goes on in a branch.
        """
        self._check_open()
        if self._trace_hash is None:
            self._trace_hash = TraceHash()
            self.on_delivery(self._trace_hash)
        return self._trace_hash.text()

    def call(self, function: "Callable[Concatenate[Self, P], T]", *arguments: P.args, **named: P.kwargs) -> T:
        """Return what `function(rig, ...)` returns, as `Branch.call` does in a branch."""
        self._check_open()
        if not callable(function):
            raise ArgumentError(f"call cannot take {shown(function)}", "expected a function that takes a rig")
        return function(self, *arguments, **named)

    def branch(self, seed: int | None = None) -> Branch:
        """Return a copy of the rig that goes on from this instant in a process of its own; close it by `with`.

        It is the rig to the last bit.  With a `seed`, its random numbers begin again from that.
        RigError where a copy would not be the whole rig: on Windows, with `processes: each`, with younger threads.
        """
        self._check_open()
        if seed is not None:
            check_seed(seed)
        check_may_branch(self)
        return self._ended_by_us(branch_of(self, seed))

    def branches(self, scenario: "Callable[[Rig, int], T]", seeds: Iterable[int], workers: int = 2) -> list[T]:
        """Call `scenario(rig, seed)` in a branch for each seed, and return the results in the order of the seeds.

        `workers` of them run at a time.  RigError with the seeds of those that failed, when all have ended.
        """
        self._check_open()
        return run_branches(self, scenario, seeds, workers)

    def checkpoint_every(self, period_ns: int, keep: int = 64) -> Callable[[], None]:
        """Keep a parked branch of the rig now and at each multiple of a period, for `back`.

        With more than `keep` of them, those in the past get rarer with their age.  Returns a function that ends it.
        """
        self._check_open()
        if type(period_ns) is not int or period_ns < 1:
            raise ArgumentError(f"checkpoint_every cannot take {shown(period_ns)}", "expected a period, such as 5 * S")
        if type(keep) is not int or keep < 2:
            raise ArgumentError(f"checkpoint_every cannot keep {shown(keep)}", "expected at least 2")
        if self._outside:
            raise RigError(
                f"a rig with members from outside has no checkpoints: {', '.join(self._outside)}", UNREPEATED
            )
        self._end_checkpoints()
        checkpoints = self._checkpoints = Checkpoints(self, period_ns, keep)
        self._park_ns = checkpoints.due_ns(self.now_ns)

        def end() -> None:
            if self._checkpoints is checkpoints:
                self._end_checkpoints()

        return end

    def back(self, ns: int) -> Branch:
        """Return a branch of the rig as it was when its clock came to `ns`; the rig stays where it is.

        It goes on from the last checkpoint before, and repeats what was asked of the rig since.
        """
        self._check_open()
        instant_ns = _whole(ns)
        if self._checkpoints is None:
            raise RigError("the rig has no checkpoints to go back to", "call checkpoint_every(5 * S) before")
        if instant_ns > self.now_ns:
            raise ArgumentError(f"the rig cannot go back to {seconds(ns)}: it is at {seconds(self.now_ns)}", "run it")
        return self._ended_by_us(self._checkpoints.back(instant_ns))

    def checkpoints(self) -> Mapping[int, int]:
        """Return the bytes of memory that each checkpoint has for itself, by its instant."""
        self._check_open()
        return {} if self._checkpoints is None else self._checkpoints.memory()

    def close(self) -> None:
        """Stop every device; the last one started is the first to stop.  Closing twice does no harm.

        Branches and checkpoints end with their rig.
        """
        self._is_closed = True
        self._end_checkpoints()
        while self._branches:
            self._branches.pop().close()
        while self._nodes:
            self._nodes.popitem()[1].stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self.close()

    def _has_clients(self) -> bool:
        return self.clients.are_there

    def _become_branch(self, seed: int | None) -> None:
        """Be the copy of a rig: what belongs to the process of the rig is not ours."""
        self.is_branch = True
        self._branches, self._checkpoints, self._park_ns = [], None, NEVER_NS
        self._is_telling = self._is_playing = False
        self._threads = threads()
        if seed is not None:
            for name, random in self._randoms.items():
                reseed(random, f"{seed}/{name}")
            for node in self._nodes.values():
                node.reseed(seed)

    def _parked(self) -> Branch:
        check_may_branch(self)
        return branch_of(self)

    def _ended_by_us(self, branch: Branch) -> Branch:
        """Return a branch that ends with this rig at the latest."""
        self._branches = [*(each for each in self._branches if not each.is_closed), branch]
        return branch

    def _park(self, next_ns: int) -> None:
        """Take the checkpoint that is due before `next_ns`; if the rig sleeps over several, the last of them.

        It is no event, so a rig makes the same steps with checkpoints and without.
        """
        if self._checkpoints is not None and self._park_ns < next_ns:
            self._park_ns = self._checkpoints.due_ns(next_ns - 1)
            self.now_ns = max(self.now_ns, self._park_ns - self._checkpoints.period_ns)
            self._checkpoints.take()

    def _end_checkpoints(self) -> None:
        if self._checkpoints is not None:
            self._checkpoints.close()
            self._checkpoints, self._park_ns = None, NEVER_NS

    def _asked(self, call: str, *arguments: Any) -> None:
        """Note a call from outside that changes the rig, so that it can be repeated."""
        if self._checkpoints is not None and not self._is_playing and not self._is_telling:
            self._checkpoints.note(call, *arguments)

    def _changed_for_good(self) -> None:
        """Take a checkpoint after something that cannot be repeated, such as a call for changes."""
        if self._checkpoints is not None and not self._is_playing:
            self._checkpoints.take(is_fixed=True)

    def _build(self, stores: Mapping[str, Store]) -> None:
        config = self.config
        for name, entry in config.devices.items():
            store = stores.get(name) or MemoryStore()
            if config.processes == "each":
                self._nodes[name] = self._elsewhere[name] = RemoteNode(entry, config.seed, store, self.buses)
            else:
                self._nodes[name] = self._here[name] = LocalNode(entry, config.seed, store, self._outbox)
            for bus in entry.buses:
                self._models[bus].join(name)
        self._step(self._nodes, 0, {})
        for name, entry in config.devices.items():
            for fault in entry.faults:
                if loses_power(entry.cls, fault):
                    self.add_fault(name, fault)
        for where in (*self._models, *self._nodes):
            for number, given in self.faults(where).items():
                if given["state"] == "waiting" and "when" in given:
                    self._triggers.forget(where, number)
                    self._arm(where, number)

    def _lose_power(self, device: str, fault: Timed) -> int:
        above = max(self._nodes[device].faults(self.now_ns), default=0)
        number = self._mains_of_all().add(self.now_ns, device, fault, above)
        self._plan()
        return number

    def _plan(self) -> None:
        """Have the rig act at its own next instant."""
        next_ns = self._own_clock.next_ns()
        self._own_ns = self._next_of[RIG] = NEVER_NS if next_ns is None else next_ns
        self._earliest_ns = min(self._next_of.values())

    def _arm(self, where: str, number: int) -> None:
        """Wait for the condition of a fault, if it has one."""
        when = self.faults(where)[number].get("when")
        if not isinstance(when, str):
            return
        self._own_clock.instant_ns = max(self._own_clock.instant_ns, self.now_ns)
        try:
            self._triggers.add(self.now_ns, where, number, condition_of(when))
        except ControlError:
            self.clear_fault(where, number)
            raise
        self._plan()

    def _begin_fault(self, where: str, number: int) -> None:
        if where in self._models:
            self._models[where].begin_fault(self.now_ns, number)
        elif self._mains is not None and self._mains.has(where, number):
            self._mains.begin(self.now_ns, where, number)
        else:
            with self._present(where) as node:  # its clock stays behind while it has no events
                node.begin_fault(number)
        if where in self._models:
            self._plan()

    def _mains_of_all(self) -> Mains:
        if self._mains is None:
            self._own_clock.instant_ns = max(self._own_clock.instant_ns, self.now_ns)
            self._mains = Mains(self._own_clock, self._switch, self._note)
        return self._mains

    def _note(self, device: str, note: FaultNote, instant_ns: int | None = None) -> None:
        """Add a fault of a device to the traces of its buses."""
        if not self._listeners:
            return
        delivery = Delivery(self.now_ns if instant_ns is None else instant_ns, device, note, ())
        for bus in self.config.devices[device].buses:
            if self.buses[bus].notes_faults:
                for listener in self._listeners:
                    listener(self.buses[bus], delivery)

    def _switch(self, device: str, is_on: bool) -> None:
        """Switch a device off or on now."""
        entry, now_ns = self.config.devices[device], self.now_ns
        for bus in entry.buses:
            if is_on:
                self._models[bus].join(device)
            else:
                self._models[bus].power_lost(now_ns, device)
        self._nodes[device].switch(now_ns, is_on)
        self._step([device], now_ns, {})

    def _add(self, member: str) -> EventNode:
        if self._checkpoints is not None:
            raise RigError("a rig with checkpoints takes no members from outside", UNREPEATED)
        node = self._outside[member] = self._here[member] = EventNode(member, self.now_ns, Outbox(self.buses))
        self._next_of[member] = NEVER_NS
        return node

    def _remove(self, member: str) -> None:
        del self._outside[member], self._here[member], self._next_of[member]
        self._earliest_ns = min(self._next_of.values(), default=NEVER_NS)

    def _looked_at(self, condition: Callable[[], T], readings: Readings) -> T:
        self._readings = readings
        try:
            return condition()
        finally:
            self._readings = None

    def _check_open(self) -> None:
        if self._is_closed:
            raise RigError("the rig is closed", "use it inside its `with` statement, or build another one")

    def _check_may_run(self) -> None:
        self._check_open()
        if self._checkpoints is not None:
            self._checkpoints.has_run = True
        if self._is_telling:
            raise RigError(
                "a call of on_change or on_instant cannot run the rig",
                "it may read and write points; run the rig after it",
            )

    def _tell(self, names: Iterable[str]) -> None:
        """Tell the changes of watched points of these devices."""
        for name in [name for name in names if name in self._watches]:
            for key, value in self._nodes[name].changes():
                for call in list(self._watches[name].get(key, ())):
                    with self._telling():
                        call(value)

    @contextmanager
    def _telling(self) -> Iterator[None]:
        was_telling, self._is_telling = self._is_telling, True
        try:
            yield
        finally:
            self._is_telling = was_telling

    def _instant(self, until_ns: int) -> int:
        """Return an instant that has not passed.  ArgumentError for anything else."""
        instant_ns = _whole(until_ns)
        if instant_ns < self.now_ns:
            raise ArgumentError(
                f"run_until cannot go back to {seconds(instant_ns)}: the rig is at {seconds(self.now_ns)}",
                "run_for(10 * MS) goes on by a duration",
            )
        return instant_ns

    def _at_end_of(self, when_ns: int, action: Callable[[], None]) -> None:
        """Call `action` when everything has happened that happens at `when_ns`; it changes nothing."""
        self._own_clock.instant_ns = max(self._own_clock.instant_ns, self.now_ns)
        self._own_clock.call_at(when_ns, lambda: self._ends.append(action))
        self._plan()

    def _node(self, device: str) -> Node:
        self._check_open()
        if not isinstance(device, str) or device not in self._nodes:
            raise _unknown("device", device, self._nodes, "bus", self._models)
        return self._nodes[device]

    def _model(self, bus: str) -> BusModel[Any]:
        self._check_open()
        if not isinstance(bus, str) or bus not in self._models:
            raise _unknown("bus", bus, self._models, "device", self._nodes)
        return self._models[bus]

    def _check_part(self, name: str) -> None:
        """ControlError for what is neither a bus nor a device."""
        self._check_open()
        if not isinstance(name, str) or (name not in self._models and name not in self._nodes):
            raise ControlError(f"the rig has no bus or device {name!r}", closest(name, [*self._models, *self._nodes]))

    @contextmanager
    def _present(self, device: str) -> Iterator[Node]:
        """Yield a device whose clock is at the present instant, then pass on what it does."""
        node = self._node(device)
        self._step([device], self.now_ns, {})
        yield node
        self._step([device], self.now_ns, {})

    def _arrival_ns(self) -> int:
        """Return the instant of the next arrival on any bus, or `NEVER_NS`."""
        earliest = NEVER_NS
        for model in self._models.values():
            arrival = model.next_ns()
            if arrival is not None and arrival < earliest:
                earliest = arrival
        return earliest

    def _run_alone(self, until_ns: int) -> bool:
        """Let the only member that acts next go on until it sends something, or others have something to do.

        Nothing arrives up to `until_ns`.  Return false if it is not the only one.  Nothing differs from a
        `_run_instant` for each of its instants, which would look at all members and buses each time.  A member from
        outside is no such member, as it has an outbox of its own; but it may be there, because nothing arrives at it
        meanwhile.
        """
        if not self._may_run_alone or self._instant_calls:
            return False
        name, next_ns, limit_ns = "", NEVER_NS, until_ns + 1
        for member, at_ns in self._next_of.items():
            if at_ns < next_ns:
                name, next_ns, limit_ns = member, at_ns, min(next_ns, limit_ns)
            elif at_ns < limit_ns:
                limit_ns = at_ns
        if not self.now_ns <= next_ns < limit_ns or name not in self._here or name in self._watches:
            return False
        if name in self._outside:
            return False
        react, outbox = self._here[name].react, self._outbox
        while next_ns < limit_ns and not outbox.sent and not outbox.listens:
            self.now_ns = next_ns
            next_ns = react(next_ns, ())
        self._next_of[name] = next_ns
        self._earliest_ns = min(self._next_of.values())
        self._hand_in(self.now_ns)
        return True

    def _run_instant(self, now_ns: int) -> None:
        self._is_playing = True
        try:
            self._play_instant(now_ns)
            if self._ends:
                ends, self._ends = self._ends, []
                for end in ends:
                    end()
        finally:
            self._is_playing = False
        for call in self._instant_calls:
            with self._telling():
                call()

    def _play_instant(self, now_ns: int) -> None:
        self.now_ns = now_ns
        inbox = self._arrivals(now_ns)
        active = self._active(now_ns, inbox)
        for _ in range(LONGEST_INSTANT):
            if not active:
                return
            self._step(active, now_ns, inbox)
            inbox = self._arrivals(now_ns)
            if not inbox and self._earliest_ns > now_ns:
                return
            active = self._active(now_ns, inbox)
        raise RigError(
            f"at {now_ns} ns {', '.join(sorted(inbox))} react to each other endlessly without time passing",
            "give one of them a turnaround time, or the bus a bit rate",
        )

    def _active(self, now_ns: int, inbox: Mapping[str, Deliveries]) -> Collection[str]:
        """Return the members that act at this instant, in the order of the configuration, which `_next_of` has."""
        if len(inbox) == 1 and self._earliest_ns > now_ns:
            return inbox
        if self._own_ns <= now_ns:
            self._own_clock.advance_to(now_ns)
            self._plan()
        return [name for name, next_ns in self._next_of.items() if name in inbox or next_ns <= now_ns]

    def _arrivals(self, now_ns: int) -> dict[str, Deliveries]:
        """Return what each member receives, in the order of the buses."""
        inbox: dict[str, Deliveries] = {}
        for bus, model in self._models.items():
            arrival_ns = model.next_ns()
            if arrival_ns is None or arrival_ns > now_ns:
                continue
            for delivery in model.collect(now_ns):
                for listener in self._listeners:
                    listener(self.buses[bus], delivery)
                arrived = ((bus, delivery.message),)  # the same for all, for they may be many
                if not inbox:
                    inbox = dict.fromkeys(delivery.receivers, arrived)
                    continue
                for receiver in delivery.receivers:
                    inbox[receiver] = (*inbox[receiver], *arrived) if receiver in inbox else arrived
        return inbox

    def _step(self, names: Collection[str], now_ns: int, inbox: Mapping[str, Deliveries]) -> None:
        """Let the members react; those in processes of their own work at the same time as those here."""
        here, next_of, deliveries_to = self._here, self._next_of, inbox.get
        elsewhere = [name for name in names if name in self._elsewhere] if self._elsewhere else ()
        for name in elsewhere:
            self._elsewhere[name].begin(now_ns, deliveries_to(name, ()))
        for name in [name for name in names if name in here] if elsewhere else names:
            next_of[name] = here[name].react(now_ns, deliveries_to(name, ()))
        self._fetch(elsewhere)
        self._earliest_ns = min(next_of.values(), default=NEVER_NS)
        if self._outside:
            for name in names:
                if name in self._outside:
                    self._gather(self._outside[name].outbox)
        self._hand_in(now_ns)
        if self._watches:
            self._tell(names)

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

    def _hand_in(self, now_ns: int) -> None:
        """Pass everything to the buses: changes of interest first, then messages."""
        models, outbox = self._models, self._outbox
        if outbox.notes:
            for device, instant_ns, note in outbox.notes:
                self._note(device, note, instant_ns)
            outbox.notes.clear()
        if outbox.listens:
            for name, bus, interest in outbox.listens:
                self._interests[name, bus] = interest
                models[bus].listen(now_ns, name, interest)
            outbox.listens.clear()
        last = None
        for name, bus, message in outbox.sent:
            if bus != last:
                last, submit = bus, models[bus].submit
            submit(now_ns, name, message)
        outbox.sent.clear()

    def _take_from_outside(self) -> None:
        """Take what a test sent or set between steps."""
        if self._outside:
            has_news, next_of = not self._outbox.is_empty, self._next_of
            for name, node in self._outside.items():
                next_ns = node.clock.next_ns()
                if next_ns is None:
                    next_ns = NEVER_NS
                if next_ns != next_of[name]:
                    next_of[name], has_news = next_ns, True
                if not node.outbox.is_empty:
                    self._gather(node.outbox)
                    has_news = True
            if has_news:
                self._earliest_ns = min(next_of.values())
                self._hand_in(self.now_ns)


class Clients:
    """The clients of the ports of a rig: members from outside, each at one bus or several.

    They have the names that they have in real time, such as `tcp:1`, so a name may be at several buses.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._buses: dict[str, list[str]] = {}
        """The buses of each client."""

    @property
    def are_there(self) -> bool:
        """True if the rig has any client."""
        return bool(self._buses)

    @property
    def are_alone(self) -> bool:
        """True if whatever happens in the rig calls nothing outside but these clients."""
        rig = self._rig
        is_heard = rig._listeners or rig._instant_calls
        return not is_heard and not rig._watches and len(rig._outside) == len(self._buses)

    def has(self, member: str, bus: str) -> bool:
        """True if no client of this name can join the bus."""
        rig = self._rig
        is_other = member in rig._nodes or (member in rig._outside and member not in self._buses)
        return is_other or bus in self._buses.get(member, ())

    def join(self, member: str, bus: str) -> EventNode:
        """Add a client to a bus.  ControlError for an unknown bus, RigError if it has a member of this name."""
        rig = self._rig
        model = rig._model(bus)
        if self.has(member, bus):
            raise RigError(f"the bus {bus!r} already has a member {member!r}", "choose another name")
        node = rig._outside.get(member) or rig._add(member)
        self._buses.setdefault(member, []).append(bus)
        model.join(member)
        return node

    def leave(self, member: str, bus: str) -> None:
        """Remove a client from a bus, with what it has sent and waits for the bus."""
        rig, buses = self._rig, self._buses[member]
        rig._take_from_outside()
        buses.remove(bus)
        rig._model(bus).leave(member)
        if not buses:
            del self._buses[member]
            rig._remove(member)

    def on_doors(self, bus: str, call: Callable[[Doors], None]) -> None:
        """Call `call` with the effects of faults of a bus on its ports."""
        self._rig._model(bus).on_doors(call)

    def waiting(self, member: str, bus: str) -> int:
        """Return how many messages of a client wait to be sent."""
        return self._rig._model(bus).waiting(member)


def _unknown(sort: str, name: str, known: Iterable[str], other_sort: str, others: Iterable[str]) -> ControlError:
    """Return the error for a name that is no device, or no bus, with what it may be instead."""
    if isinstance(name, str) and name in others:
        return ControlError(f"{name!r} is a {other_sort}, not a {sort}", closest("", list(known)))
    return ControlError(f"the rig has no {sort} {name!r}", closest(name, list(known)))


def _whole(ns: int) -> int:
    try:
        return whole_ns(ns)
    except TypeError as wrong:
        raise ArgumentError(str(wrong)) from None


def _without(calls: tuple[C, ...], call: C) -> tuple[C, ...]:
    """Return the calls without the first one that is `call`."""
    place = next((place for place, each in enumerate(calls) if each == call), len(calls))
    return calls[:place] + calls[place + 1 :]
