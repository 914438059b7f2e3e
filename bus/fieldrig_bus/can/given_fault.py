"""Reads a fault that is given to a running CAN bus: by a test as plain values, by `fieldrig fault` as texts."""

from collections.abc import Mapping
from typing import Any, Final, cast

from fieldrig.faults import faults
from fieldrig_bus.can.faults import CanFault

MODELS: Final = faults.models_of(CanFault)


def fault_of(given: Mapping[str, Any]) -> CanFault:
    """Return the settings of a fault of a CAN bus.

    ValueError: its first line says what is wrong, further lines say what was expected.
    """
    return cast(CanFault, faults.fault_of(given, MODELS))
