"""What tools are told about a point, beside its value."""

from collections.abc import Mapping
from typing import Any

from fieldrig.device import Point


def facts_of(points: Mapping[str, Point]) -> dict[str, dict[str, Any]]:
    """Return the facts of each point by its key, in values that JSON has; `states` only of a state with a name."""
    return {
        key: {"unit": point.unit, "about": point.about, "writable": point.write is not None}
        | ({"states": list(point.states)} if point.states else {})
        for key, point in points.items()
    }
