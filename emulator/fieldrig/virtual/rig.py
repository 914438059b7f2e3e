"""Nodes, buses and one clock from one configuration, under virtual time.

What happens at an instant is the engine's (`engine`); here is what its user may ask, and when.  The same seed gives the
same bytes on every bus, with all nodes in this process or each in its own.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, Self, TypeVar, overload

from fieldrig.bus import BusModel
from fieldrig.clock import NEVER_NS, whole_ns
from fieldrig.config.rig_file import RigConfig
from fieldrig.device import Device, Value
from fieldrig.errors import ArgumentError, ControlError, RigError
from fieldrig.outside.untrusted import shown
from fieldrig.points.names import split_point, written_point
from fieldrig.recording.signals import Rhythm, wish_of
from fieldrig.storage.store import Store
from fieldrig.system.garbage import without_searches
from fieldrig.system.threads import threads
from fieldrig.text.nearest import closest
from fieldrig.virtual.branch import Branch, branch_of
from fieldrig.virtual.branches import check_seed, outliving, run_branches
from fieldrig.virtual.clients import Clients
from fieldrig.virtual.engine import Engine, OnChange, OnDelivery
from fieldrig.virtual.may_branch import check_may_branch
from fieldrig.virtual.node import EventNode, LocalNode, Node
from fieldrig.virtual.past import Past
from fieldrig.virtual.readings import Readings, seconds
from fieldrig.virtual.rig_faults import RigFaults
from fieldrig.virtual.trace_hash import TraceHash
from fieldrig.virtual.until import duration, run_until_met, run_while_met

if TYPE_CHECKING:
    from fieldrig.recording.recording import Recording

T = TypeVar("T")
P = ParamSpec("P")
C = TypeVar("C")


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
        self._engine = Engine(config)
        self.buses = self._engine.buses
        if on_delivery is not None:
            self._engine.listeners = (on_delivery,)
        self.clients = Clients(self._engine, self._add, self._model)
        """The clients of ports, in a block of `virtual_time`."""
        self._faults = RigFaults(self._engine, self)
        self._stores = dict(stores or {})
        self._threads = threads()
        """The threads that are older than the rig."""
        self.is_branch = False
        """True in a branch, where the calls of `on_delivery`, `on_change` and `on_instant` are made as well."""
        self._past = Past(self, self._engine)
        self._trace_hash: TraceHash | None = None
        self._readings: Readings | None = None
        """The record of points that are read, while a condition is looked at."""
        try:
            with without_searches():
                self._engine.build(self._stores)
            self._faults.begin_all()
        except BaseException:
            self.close()
            raise

    @property
    def now_ns(self) -> int:
        """The present instant, in nanoseconds since the rig was built."""
        return self._engine.now_ns

    def next_ns(self) -> int | None:
        """Return the instant at which something happens next; None if nothing ever will."""
        self._check_open()
        self._engine.take_from_outside()
        earliest = min(self._engine.earliest_ns, self._engine.arrival_ns())
        return None if earliest == NEVER_NS else max(earliest, self.now_ns)

    def step(self) -> bool:
        """Go to the next instant at which something happens, and let it happen.  False if nothing ever will."""
        self._check_may_run()
        next_ns = self.next_ns()
        if next_ns is not None:
            self._past.park(next_ns)
            self._engine.run_instant(next_ns)
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
        engine, past = self._engine, self._past
        while is_reached:
            self._check_open()
            engine.take_from_outside()
            arrival_ns = engine.arrival_ns()
            next_ns = max(min(engine.earliest_ns, arrival_ns), engine.now_ns)
            if next_ns > until_ns or next_ns == NEVER_NS:
                break
            past.park(next_ns)
            if engine.earliest_ns >= arrival_ns or not engine.run_alone(min(until_ns, past.due_ns, arrival_ns - 1)):
                engine.run_instant(next_ns)
                is_reached = stop is None or not stop()
        if is_reached:
            past.park(until_ns + 1)
            engine.now_ns = max(engine.now_ns, until_ns)
        for node in engine.outside.values():
            node.clock.instant_ns = engine.now_ns
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
        if member in self._engine.nodes or member in self._engine.outside:
            raise RigError(f"the rig already has a member {member!r}", "choose another name")
        node = self._add(member)
        for model in self._engine.models.values():
            model.join(member)
        return node

    def detach(self, member: str) -> None:
        """Remove a member that was attached, with its timers and with what it has sent and waits for its bus."""
        self._check_open()
        if not isinstance(member, str) or member not in self._engine.outside:
            raise RigError(f"{shown(member)} is not attached", closest(str(member), list(self._engine.outside)))
        self._engine.take_from_outside()
        self._engine.remove(member)
        for model in self._engine.models.values():
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
        self._past.note("set", device, key, value)
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
        if not self._engine.watches.get(device, {}).get(key):
            node.watch(self.now_ns, key)
        calls = self._engine.watches.setdefault(device, {}).setdefault(key, [])
        calls.append(call)
        self._past.keep_now()

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
        self._engine.listeners = (*self._engine.listeners, call)
        self._past.keep_now()

        def end() -> None:
            self._engine.listeners = _without(self._engine.listeners, call)

        return end

    def on_instant(self, call: Callable[[], None]) -> Callable[[], None]:
        """Call `call()` at the end of each instant at which something happens; returns a function that ends it.

        Everything has happened then that happens at `now_ns`.  `call` may read and write points, but not run the rig.
        """
        self._check_open()
        if not callable(call):
            raise ArgumentError(f"on_instant cannot call {shown(call)}", "expected a function without arguments")
        self._engine.instant_calls = (*self._engine.instant_calls, call)
        self._past.keep_now()

        def end() -> None:
            self._engine.instant_calls = _without(self._engine.instant_calls, call)

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
        self._past.note("answer", device, question, message)
        with self._present(device) as node:
            return node.answer(question, message)

    def statistics(self, bus: str) -> dict[str, float]:
        """Return frames, load and other figures of a bus, by name.  ControlError if there is no such bus."""
        return self._model(bus).statistics(self.now_ns)

    def signals(self, bus: str, names: Iterable[str] | None = None) -> dict[str, dict[str, Any]]:
        """Return the facts of these signals of a bus that have a value, such as wires, by name; None stands for all."""
        standing = self._model(bus).standing()
        if names is not None:
            standing = {name: standing[name] for name in names if name in standing}
        return self.buses[bus].signals(standing, self.now_ns)

    def interests(self, bus: str) -> dict[str, Any]:
        """Return the interest of each member of a bus: names of wires, unit ids or filters; None for everything."""
        self._model(bus)
        return {name: interest for (name, known), interest in self._engine.interests.items() if known == bus}

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
        self._past.note("add_fault", where, fault)
        return self._faults.add(where, fault)

    def restart(self, device: str) -> None:
        """Switch a device off and on again at the present instant; it keeps its non-volatile memory and its faults."""
        self._node(device)
        self._past.note("restart", device)
        self._faults.restart(device)

    def clear_fault(self, where: str, number: int) -> None:
        """Remove a fault of a bus or a device.  ControlError if there is none of this number."""
        self._check_part(where)
        if type(number) is not int:
            raise ArgumentError(f"a fault cannot have the number {shown(number)}", "expected what add_fault returned")
        self._past.note("clear_fault", where, number)
        self._faults.clear(where, number)

    def faults(self, where: str) -> Mapping[int, Mapping[str, Any]]:
        """Return the faults of a bus or a device that were added and not cleared, by number."""
        self._check_part(where)
        return self._faults.all_of(where)

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
        return self._past.owned(branch_of(self, seed))

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
        return self._past.keep_every(period_ns, keep)

    def back(self, ns: int) -> Branch:
        """Return a branch of the rig as it was when its clock came to `ns`; the rig stays where it is.

        It goes on from the last checkpoint before, and repeats what was asked of the rig since.
        """
        self._check_open()
        return self._past.back(_whole(ns))

    def checkpoints(self) -> Mapping[int, int]:
        """Return the bytes of memory that each checkpoint has for itself, by its instant."""
        self._check_open()
        return self._past.memory()

    def close(self) -> None:
        """Stop every device; the last one started is the first to stop.  Closing twice does no harm.

        Branches and checkpoints end with their rig.
        """
        self._is_closed = True
        self._past.close()
        self._engine.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self.close()

    @property
    def _is_playing(self) -> bool:
        return self._engine.is_playing

    def _has_clients(self) -> bool:
        return self.clients.are_there

    def _become_branch(self, seed: int | None) -> None:
        """Be the copy of a rig: what belongs to the process of the rig is not ours."""
        self.is_branch = True
        self._past = Past(self, self._engine)
        self._engine.is_telling = self._engine.is_playing = False
        self._threads = threads()
        if seed is not None:
            self._engine.reseed(seed)

    def _parked(self) -> Branch:
        return outliving(self)

    def _add(self, member: str) -> EventNode:
        self._past.check_takes_members()
        return self._engine.add(member)

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
        self._past.note_run()
        if self._engine.is_telling:
            raise RigError(
                "a call of on_change or on_instant cannot run the rig",
                "it may read and write points; run the rig after it",
            )

    def _instant(self, until_ns: int) -> int:
        """Return an instant that has not passed.  ArgumentError for anything else."""
        instant_ns = _whole(until_ns)
        if instant_ns < self.now_ns:
            raise ArgumentError(
                f"run_until cannot go back to {seconds(instant_ns)}: the rig is at {seconds(self.now_ns)}",
                "run_for(10 * MS) goes on by a duration",
            )
        return instant_ns

    def _node(self, device: str) -> Node:
        self._check_open()
        if not isinstance(device, str) or device not in self._engine.nodes:
            raise _unknown("device", device, self._engine.nodes, "bus", self._engine.models)
        return self._engine.nodes[device]

    def _model(self, bus: str) -> BusModel[Any]:
        self._check_open()
        if not isinstance(bus, str) or bus not in self._engine.models:
            raise _unknown("bus", bus, self._engine.models, "device", self._engine.nodes)
        return self._engine.models[bus]

    def _check_part(self, name: str) -> None:
        """ControlError for what is neither a bus nor a device."""
        self._check_open()
        if not isinstance(name, str) or (name not in self._engine.models and name not in self._engine.nodes):
            known = [*self._engine.models, *self._engine.nodes]
            raise ControlError(f"the rig has no bus or device {name!r}", closest(name, known))

    @contextmanager
    def _present(self, device: str) -> Iterator[Node]:
        """Yield a device whose clock is at the present instant, then pass on what it does."""
        self._node(device)
        with self._engine.present(device) as node:
            yield node


def devices_of(rig: Rig) -> Sequence[Device]:
    """Return the devices of a rig that run in this process, for tools that look into them."""
    return [node.device for node in rig._engine.nodes.values() if isinstance(node, LocalNode)]


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
