"""The fault that every device can have: it has no power."""

from collections.abc import Mapping
from typing import Any, Final, Literal

from fieldrig.device import POWER_OFF, Device
from fieldrig.faults.faults import Timed


class PowerOff(Timed):
    """The device has no power, and starts again when the fault ends."""

    what: Literal["power_off"]


MODELS: Final[Mapping[str, type[Timed]]] = {POWER_OFF: PowerOff}


def loses_power(device: type[Device], fault: Mapping[str, Any]) -> bool:
    """Return whether a fault is the loss of power of a kind of device that has none in more detail."""
    return fault.get("what") == POWER_OFF and POWER_OFF not in device.fault_models


def models_of_device(device: type[Device]) -> Mapping[str, type[Any]]:
    """Return the faults of a kind of device: its own, and the loss of power, which some have in more detail."""
    return {**MODELS, **device.fault_models}
