"""The faults that the devices and buses of a shipped rig declare, each with every choice of its keys."""

from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import entry_points
from itertools import cycle, product
from pathlib import Path
from typing import Any, Final, Literal, NamedTuple, get_args, get_origin

from fieldrig.config.rig_file import RigConfig, load

CONFIGS: Final = Path(__file__).parents[2] / "configs"
VALUES: Final[Mapping[str, Any]] = {
    "us": 5_000,
    "percent": 5,
    "address": 101,
    "number": 1,
    "sensor": "",
    "identifier": 0x7F,
    "bitrate": 125_000,
    "delay_ms": 20,
    "bit_error_rate": 0.2,
    "highest_bps": 9_600,
    "node": "",
    "after": "",
    "station": "",
    "key": "F2",
}
"""Values of keys that have no list of choices: those that a fault requires, and some that let it be felt.

A text that is empty stands for the name of a member or a sensor.
"""
FELT: Final = frozenset({"percent", "address", "sensor"})
"""Keys that a fault does not require, and without which it would not be felt."""
EITHER: Final[Mapping[str, Mapping[str, Any]]] = {"replace": {"xor": "FF"}, "distort": {"after": ""}}
"""A key of faults that require one of two, which their models cannot say."""


OF_MESSAGES: Final = frozenset({"ip", "modbus", "opcua", "serial", "tcp", "wires"})
"""Families whose faults damage any message, and so are tried with their buses (`tests/bus`), not with each machine."""
OF_PROTOCOLS: Final = frozenset({"fieldrig_devices.canopen.node_faults", "fieldrig_devices.modbus.faults"})
"""Modules whose faults break a protocol, and so are tried with their devices."""


BUSES: Final = frozenset(point.name for point in entry_points(group="fieldrig.buses"))


class Injected(NamedTuple):
    """A fault, and the bus or device that it is given to."""

    where: str
    kind: str
    fault: dict[str, Any]

    @property
    def words(self) -> tuple[str, ...]:
        """Return its kind, `what`, and the choices of its keys."""
        chosen = (str(value) for key, value in self.fault.items() if key not in VALUES and key != "xor")
        return self.kind.partition(".")[0] if self.is_of_bus else self.kind, *chosen

    @property
    def is_of_bus(self) -> bool:
        return self.kind in BUSES


def choices(model: Any) -> Iterator[dict[str, Any]]:
    """Yield a fault of this model for each combination of the values that its keys name."""
    keys: dict[str, list[Any]] = {}
    for name, field in model.model_fields.items():
        if get_origin(field.annotation) is Literal:
            keys[name] = list(get_args(field.annotation))
        elif field.is_required() or name in FELT:
            keys[name] = [VALUES[name]]
    for values in product(*keys.values()):
        fault = dict(zip(keys, values, strict=True))
        yield {**EITHER.get(fault["what"], {}), **fault}


def faults_of(config: RigConfig | str, wheres: Sequence[str] | None = None) -> list[Injected]:
    """Return the faults of a rig, or of these buses and devices of it.

    Buses or devices with the same faults take turns, and each of them has at least one.
    """
    config = load(CONFIGS / config) if isinstance(config, str) else config
    groups: dict[tuple[Any, ...], list[tuple[str, str, Sequence[str]]]] = {}
    models: dict[tuple[Any, ...], Mapping[str, Any]] = {}
    for name, device in config.devices.items():
        names = list(getattr(device.settings, "sensors", ()))
        own = {what: of for what, of in device.cls.fault_models.items() if of.__module__ not in OF_PROTOCOLS}
        groups.setdefault((device.cls, *own), []).append((name, device.kind, names))
        models[device.cls, *own] = own
    for name, bus in config.buses.items():
        cls = type(bus.bus)
        if cls.family in OF_MESSAGES:
            continue
        groups.setdefault((cls, *cls.fault_models), []).append((name, bus.kind, _stations(config, name)))
        models[cls, *cls.fault_models] = cls.fault_models
    found = []
    for key, places in groups.items():
        there = [place for place in places if wheres is None or place[0] in wheres]
        faults = [fault for model in models[key].values() for fault in choices(model)]
        if faults and there:
            pairs = zip(cycle(there), cycle(faults), range(max(len(faults), len(there))))
            found += [Injected(name, kind, _named(fault, names, count)) for (name, kind, names), fault, count in pairs]
    return found


def _stations(config: RigConfig, bus: str) -> list[str]:
    """Return the members of a bus, those of a ring without its master."""
    entry = config.buses[bus]
    masters = ("max4", "pam") if "ring" in entry.kind else ()
    return [name for name in entry.members if config.devices[name].kind not in masters]


def _named(fault: dict[str, Any], names: Sequence[str], count: int) -> dict[str, Any]:
    """Return a fault with a name of those that there are, each time another one."""
    return {key: names[count % len(names)] if value == "" else value for key, value in fault.items()}
