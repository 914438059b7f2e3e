"""A fault as it is given to a running bus: by a test as plain values, by `fieldrig fault` as texts."""

from collections.abc import Mapping
from typing import Any, Final, cast

from fieldrig import faults
from fieldrig_bus.can.faults import CanFault

MODELS: Final = faults.models_of(CanFault)
TEXTS: Final = frozenset({"what", "node", "data", "xor", "level"})
"""Keys whose values are texts, even where YAML would see a number: data 0102, or a node named 5."""


def fault_of(given: Mapping[str, Any]) -> CanFault:
    """ValueError if that is no fault: what is wrong, and on further lines what would be right."""
    return cast(CanFault, faults.fault_of(given, MODELS, TEXTS))
