"""The signals of buses, such as wires, in the conditions of faults: `wires/tank.level > 1.5`."""

from collections.abc import Mapping
from typing import Any, cast

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.text.nearest import closest


def value_of(bus: str, name: str, signals: Mapping[str, Mapping[str, Any]]) -> Value:
    """Return the present value of a signal.  ControlError if none of this name has been sent."""
    if name not in signals:
        raise ControlError(f"{bus} has no value of a signal {name!r}", closest(name, list(signals)))
    return cast(Value, signals[name]["value"])
