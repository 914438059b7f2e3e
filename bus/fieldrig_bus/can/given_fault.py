"""Reads a fault that is added to a running bus: plain values from a test, or text from `fieldrig fault`."""

from collections.abc import Mapping
from typing import Any, Final, cast

from fieldrig import faults
from fieldrig_bus.can.faults import CanFault

MODELS: Final = faults.models_of(CanFault)
TEXTS: Final = frozenset({"what", "node", "data", "xor", "level"})
"""Keys whose values are text even where YAML would read a number: data 0102, or a node named 5."""


def fault_of(given: Mapping[str, Any]) -> CanFault:
    """The settings of a fault.  ValueError if it is none, with what was expected on further lines."""
    return cast(CanFault, faults.fault_of(given, MODELS, TEXTS))
