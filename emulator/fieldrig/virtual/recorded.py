"""The devices and buses of a rig in virtual time, as recordings see them.

Recording is no event: the trace is the same with it and without.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.recording.bus_signals import BusSignals, OnDelivery
from fieldrig.recording.device_points import PointReads, describe
from fieldrig.recording.signals import NAN, Described, End, OnCycle, RecordedPart
from fieldrig.text.nearest import closest
from fieldrig.virtual.node import LocalNode

if TYPE_CHECKING:
    from fieldrig.bus import Bus, Delivery
    from fieldrig.virtual.rig import Rig


class RigSource:
    """The devices and buses of a rig (`recording.signals.Source`)."""

    def __init__(self, rig: "Rig") -> None:
        self._rig = rig
        self.on_rows: Callable[[], None] = lambda: None
        """Never called: a rig in virtual time is in no hurry."""

    def now_ns(self) -> int:
        return self._rig.now_ns

    def part(self, name: str) -> RecordedPart:
        rig = self._rig
        if name in rig.buses:
            model = rig._model(name)
            return BusSignals(rig.buses[name], model.standing, partial(self._listen, name), self.now_ns)
        if name not in rig.config.devices:
            raise ControlError(
                f"the rig has no device or bus {name!r}", closest(name, [*rig.config.devices, *rig.buses])
            )
        return DeviceSignals(rig, name)

    def every(self, period_ns: int, action: Callable[[int, int], None]) -> End:
        """Call `action` when everything that happens at an instant has happened."""
        rig, is_on = self._rig, True

        def due() -> None:
            if is_on:
                action(rig.now_ns, 0)
                rig._engine.at_end_of(rig.now_ns + period_ns, due)

        def end() -> None:
            nonlocal is_on
            is_on = False

        rig._engine.at_end_of((rig.now_ns // period_ns + 1) * period_ns, due)
        return end

    def _listen(self, bus: str, on_delivery: OnDelivery) -> End:
        def heard(of_bus: "Bus[Any]", delivery: "Delivery[Any]") -> None:
            if of_bus.name == bus:
                on_delivery(delivery)

        return self._rig.on_delivery(heard)


class DeviceSignals:
    """The points of one device (`recording.signals.RecordedPart`)."""

    is_bus: ClassVar[bool] = False

    def __init__(self, rig: "Rig", name: str) -> None:
        self._rig, self._name = rig, name
        node = rig._node(name)
        self._local = node if isinstance(node, LocalNode) else None
        """The device, if it is in this process."""

    def describe(self, keys: Sequence[str]) -> list[Described]:
        if self._local is not None:
            self._local.look_at(self._rig.now_ns)
            return describe(self._name, self._local.device, keys)
        values, facts = self._rig.values(self._name, keys), self._rig.facts(self._name)
        return [Described(values[key], facts[key]["unit"], facts[key].get("states", ())) for key in keys]

    def reader(self, keys: Sequence[str]) -> Callable[[], Sequence[Value]]:
        rig, local = self._rig, self._local
        if local is None:
            return partial(self._fetched, list(keys))
        reads = PointReads(lambda: local.device if local.is_on else None, keys)

        def read() -> Sequence[Value]:
            local.look_at(rig.now_ns)
            return reads()

        return read

    def _fetched(self, keys: list[str]) -> Sequence[Value]:
        """Return the values of a device in a process of its own."""
        try:
            values = self._rig.values(self._name, keys)
        except ControlError:  # it has no power, or a point has gone with its program
            return [NAN] * len(keys)
        return [values[key] for key in keys]

    def on_cycle(self, action: OnCycle) -> End | None:
        local = self._local
        if local is None or not local.device.has_cycle:
            return None
        return local.cycle_hook.add(lambda: action(local.clock.now_ns(), 0))

    def close(self) -> None:
        """Do nothing: a device is read only when a row is taken."""

    def on_change(self, keys: Sequence[str], action: Callable[[int, int, Value], None]) -> End:
        rig = self._rig

        def told(place: int, value: Value) -> None:
            action(rig.now_ns, place, value)

        ends = [rig.on_change(f"{self._name}/{key}", partial(told, place)) for place, key in enumerate(keys)]

        def end() -> None:
            for each in ends:
                each()

        return end
