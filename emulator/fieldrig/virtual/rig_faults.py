"""The faults of a rig in virtual time: of its buses, of its devices, and of their power, in one list for each."""

from collections.abc import Callable, Container, Iterable, Mapping
from functools import cache, partial
from typing import Any, Protocol

from fieldrig.bus import Bus, Delivery
from fieldrig.control.fault_asking import check_members
from fieldrig.device import Value
from fieldrig.errors import ControlError, refusals
from fieldrig.faults.condition import Condition, check_possible, condition_of
from fieldrig.faults.faults import Timed, fault_of
from fieldrig.faults.mains import Mains
from fieldrig.faults.power import MODELS, loses_power
from fieldrig.faults.signals import driven_on, value_of
from fieldrig.faults.triggers import Points, Triggers
from fieldrig.points.names import split_point
from fieldrig.virtual.engine import Engine


class RigPoints(Points, Protocol):
    def facts(self, device: str) -> Mapping[str, Mapping[str, Any]]: ...

    def signals(self, bus: str, names: Iterable[str] | None = None) -> Mapping[str, Mapping[str, Any]]: ...

    def on_delivery(self, call: Callable[[Bus[Any], Delivery[Any]], None]) -> Callable[[], None]: ...


class _WithSignals:
    """The points of a rig, and the signals of its buses beside them."""

    def __init__(self, points: RigPoints, buses: Container[str], driven_on: Callable[[str], Container[str]]) -> None:
        self._points, self._buses, self._driven_on = points, buses, driven_on

    def get(self, point: str, key: str | None = None) -> Value:
        name, key = split_point(point, key)
        if name in self._buses:
            return value_of(name, key, self._points.signals(name), self._driven_on(name))
        return self._points.get(name, key)

    def on_change(self, point: str, call: Callable[[Value], None]) -> Callable[[], None]:
        name, key = split_point(point)
        if name not in self._buses:
            return self._points.on_change(point, call)

        def heard(bus: Bus[Any], _: Delivery[Any]) -> None:
            if bus.name == name and key in self._points.signals(name, [key]):
                call(self.get(point))

        return self._points.on_delivery(heard)


class RigFaults:
    """All calls are at the present instant; `where` is the name of a bus or a device that the rig has."""

    def __init__(self, engine: Engine, points: RigPoints) -> None:
        self._engine, self._points = engine, points
        self._values = _WithSignals(points, engine.models, cache(partial(driven_on, engine.config)))
        self._triggers = Triggers(engine.clock, self._values, self._begin, engine.plan)
        self._mains: Mains | None = None
        """The power of the devices, once it has been switched."""

    def begin_all(self) -> None:
        """Begin the faults of the rig file that the nodes themselves do not."""
        engine = self._engine
        for name, entry in engine.config.devices.items():
            for fault in entry.faults:
                if loses_power(entry.cls, fault):
                    self.add(name, fault)
        for where in (*engine.models, *engine.nodes):
            for number, given in self.all_of(where).items():
                if given["state"] == "waiting" and "when" in given:
                    self._triggers.forget(where, number)
                    self._arm(where, number)

    def add(self, where: str, fault: Mapping[str, Any]) -> int:
        """Add a fault, and return its number.  ControlError for one that is refused."""
        engine = self._engine
        if where in engine.models:
            check_members(fault, [*engine.nodes, *engine.outside])
            with refusals(where):
                number = engine.models[where].add_fault(engine.now_ns, fault)
        elif loses_power(engine.config.devices[where].cls, fault):
            with refusals(where):
                number = self._lose_power(where, fault_of(fault, MODELS))
        else:
            with engine.present(where) as node:
                number = node.add_fault(fault, 0 if self._mains is None else self._mains.given(where))
        self._arm(where, number)
        return number

    def clear(self, where: str, number: int) -> None:
        """Remove a fault.  ControlError if there is none of this number."""
        engine = self._engine
        self._triggers.forget(where, number)
        if where in engine.models:
            with refusals(where):
                engine.models[where].clear_fault(engine.now_ns, number)
        elif self._mains is not None and self._mains.has(where, number):
            self._mains.clear(engine.now_ns, where, number)
        else:
            with engine.present(where) as node:
                node.clear_fault(number)

    def all_of(self, where: str) -> Mapping[int, Mapping[str, Any]]:
        """Return the faults that were added and not cleared, by number."""
        engine = self._engine
        if where in engine.models:
            return engine.models[where].all_faults(engine.now_ns)
        own = engine.nodes[where].faults(engine.now_ns)
        return own if self._mains is None else dict(sorted({**own, **self._mains.about(engine.now_ns, where)}.items()))

    def restart(self, device: str) -> None:
        """Switch a device off and on again.  ControlError for one that a fault has switched off."""
        if self._mains is not None and self._mains.is_off(device):
            raise ControlError(f"{device} is switched off", "clear the fault that has switched it off")
        self._engine.switch(device, False)
        self._engine.switch(device, True)

    def _lose_power(self, device: str, fault: Timed) -> int:
        engine = self._engine
        above = max(engine.nodes[device].faults(engine.now_ns), default=0)
        if self._mains is None:
            engine.catch_up()
            self._mains = Mains(engine.clock, engine.switch, engine.note)
        number = self._mains.add(engine.now_ns, device, fault, above)
        engine.plan()
        return number

    def _arm(self, where: str, number: int) -> None:
        """Wait for the condition of a fault, if it has one."""
        when = self.all_of(where)[number].get("when")
        if not isinstance(when, str):
            return
        self._engine.catch_up()
        condition = condition_of(when)
        try:
            self._check(condition)
            self._triggers.add(self._engine.now_ns, where, number, condition)
        except ControlError:
            self.clear(where, number)
            raise
        self._engine.plan()

    def _check(self, condition: Condition) -> None:
        """ControlError for a condition that can never be met."""
        name = condition.device
        facts = self._points.facts(name) if name in self._engine.nodes else {}
        present, states = self._values.get(condition.point), facts.get(condition.key, {}).get("states", ())
        check_possible(condition, present, states)

    def _begin(self, where: str, number: int) -> None:
        engine = self._engine
        if where in engine.models:
            engine.models[where].begin_fault(engine.now_ns, number)
            engine.plan()
        elif self._mains is not None and self._mains.has(where, number):
            self._mains.begin(engine.now_ns, where, number)
        else:
            with engine.present(where) as node:  # its clock stays behind while it has no events
                node.begin_fault(number)
