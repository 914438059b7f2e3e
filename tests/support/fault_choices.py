"""The faults that the devices of a shipped rig declare, each with every choice of its keys."""

from collections.abc import Iterator, Mapping
from itertools import cycle, product
from pathlib import Path
from typing import Any, Final, Literal, get_args, get_origin

from fieldrig.config import load

CONFIGS: Final = Path(__file__).parents[2] / "configs"
VALUES: Final[Mapping[str, Any]] = {"us": 5_000, "percent": 5, "address": 101, "number": 1, "sensor": ""}
"""Values of keys that have no list of choices: those that a fault requires, and some that let it be felt."""


def choices(model: Any) -> Iterator[dict[str, Any]]:
    """Yield a fault of this model for each combination of the values that its keys name."""
    keys: dict[str, list[Any]] = {}
    for name, field in model.model_fields.items():
        if get_origin(field.annotation) is Literal:
            keys[name] = list(get_args(field.annotation))
        elif name in VALUES:
            keys[name] = [VALUES[name]]
    yield from (dict(zip(keys, values, strict=True)) for values in product(*keys.values()))


def _fitting(fault: dict[str, Any], settings: Any) -> dict[str, Any]:
    """Return a fault with the name of a sensor that the device has."""
    return fault | {"sensor": next(iter(settings.sensors))} if "sensor" in fault else fault


def faults_of(rig: str) -> list[tuple[str, dict[str, Any]]]:
    """Return device and fault.  Devices with the same faults take turns, and each of them has at least one."""
    groups: dict[tuple[Any, ...], list[tuple[str, Any]]] = {}
    for name, device in load(CONFIGS / rig).devices.items():
        models = device.cls.fault_models
        if models:
            groups.setdefault((device.cls, *models), []).append((name, device))
    found = []
    for (cls, *_), devices in groups.items():
        faults = [fault for model in cls.fault_models.values() for fault in choices(model)]
        pairs = zip(cycle(devices), cycle(faults), range(max(len(faults), len(devices))))
        found += [(name, _fitting(fault, device.settings)) for (name, device), fault, _ in pairs]
    return found
