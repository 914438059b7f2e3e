"""The fault that every device can have: it has no power."""

from collections.abc import Mapping
from typing import Any, Final, Literal

from fieldrig.device import Device
from fieldrig.faults.faults import Timed


class PowerOff(Timed):
    """The device has no power, and starts again when the fault ends."""

    what: Literal["power_off"]


POWER_OFF: Final = "power_off"
MODELS: Final[Mapping[str, type[Timed]]] = {POWER_OFF: PowerOff}


def models_of_device(device: type[Device]) -> Mapping[str, type[Any]]:
    """Return the faults of a kind of device: its own, and the loss of power, which some have in more detail."""
    return {**MODELS, **device.fault_models}
