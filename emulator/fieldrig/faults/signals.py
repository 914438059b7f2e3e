"""The signals of buses, such as wires, in the conditions of faults: `wires/tank.level > 1.5`."""

from collections.abc import Container, Mapping
from typing import Any, cast

from fieldrig.config.rig_file import RigConfig
from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.text.nearest import closest


def value_of(bus: str, name: str, signals: Mapping[str, Mapping[str, Any]], driven: Container[str]) -> Value:
    """Return the present value of a signal; one that a device drives, and has not sent yet, is false.

    ControlError for a signal that has not been sent, and that no device drives.
    """
    if name in signals:
        return cast(Value, signals[name]["value"])
    if name in driven:
        return False
    raise ControlError(f"{bus} has no value of a signal {name!r}", closest(name, list(signals)))


def driven_on(config: RigConfig, bus: str) -> frozenset[str]:
    """Return the names of the wires of a bus that the devices of a rig file drive."""
    linked = (entry for entry in config.devices.values() if bus in entry.buses)
    claims = (claim for entry in linked for claim in entry.settings.claims(entry.name))
    return frozenset(str(claim.value) for claim in claims if claim.what == "wire")
