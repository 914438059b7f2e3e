"""The places of a scenario in a rig in real time, sorted by what reads them: recordings, and the messages of buses."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from fieldrig.config.rig_file import RigConfig
from fieldrig.device import Value
from fieldrig.points.names import split_point
from fieldrig.real.running_rig import RunningRig
from fieldrig_devices.scenarios.calls import Call, call_of
from fieldrig_devices.scenarios.diagnoses import diagnosis_keys, shows


class Derived(NamedTuple):
    """A place that depends on points: a diagnosis."""

    points: tuple[str, ...]
    shows: Callable[[Value], bool]

    def value(self, values: Mapping[str, Value]) -> bool:
        return any(self.shows(values[point]) for point in self.points if point in values)


class LivePlaces:
    """Places by their sorts."""

    def __init__(self, rig: RunningRig, config: RigConfig, names: Iterable[str]) -> None:
        """ControlError for a place that the rig does not have."""
        self._rig, self._config = rig, config
        self.points: dict[str, Value] = {}
        """The points of devices that are recorded, with their present values."""
        self.calls: list[Call] = []
        """The places of messages."""
        self.signals: dict[tuple[str, str], Value] = {}
        """The signals of buses, with their present values; before its first message a wire is False."""
        self.derived: dict[str, Derived] = {}
        self._named = dict.fromkeys(names)
        for name in self._named:
            self._sort(name)

    def values(self) -> dict[str, Value]:
        """Return the present values of all places but those of messages; a point of a diagnosis alone is none."""
        points = {name: value for name, value in self.points.items() if name in self._named}
        signals = {f"{bus}/{key}": value for (bus, key), value in self.signals.items()}
        return {**points, **signals, **{name: one.value(self.points) for name, one in self.derived.items()}}

    def _sort(self, name: str) -> None:
        call = call_of(name)
        if call is None:
            part, key = split_point(name)
            if part in self._config.buses:
                self.signals[part, key] = self._signal(part, key)
            else:
                self.points[name] = self._rig.get(name)
        elif call.kind == "diagnosis":
            known = self._rig.ask(f"device/{call.target}/keys") if call.target in self._config.devices else ()
            keys = diagnosis_keys(self._config, call.target, known)
            self.derived[name] = Derived(tuple(f"{call.target}/{key}" for key in keys), shows(call.number))
            self.points |= {point: self._rig.get(point) for point in self.derived[name].points}
        else:
            self.calls.append(call)

    def _signal(self, bus: str, key: str) -> Value:
        known: Mapping[str, Mapping[str, Value]] = self._rig.ask(f"bus/{bus}/keys")
        if key in known:
            return known[key]["value"]
        return False  # nothing has been on it yet
