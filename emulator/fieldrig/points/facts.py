"""Facts of the points of a device, for tools, in values that JSON has."""

from collections.abc import Mapping
from typing import Any

from fieldrig.device import Point


def facts_of(points: Mapping[str, Point]) -> dict[str, dict[str, Any]]:
    """Return unit, description and access of each point, by key; type, limits and states where a point has them."""
    return {key: fact_of(point) for key, point in points.items()}


def fact_of(point: Point) -> dict[str, Any]:
    """Return the facts of one point."""
    facts: dict[str, Any] = {"unit": point.unit, "about": point.about, "writable": point.write is not None}
    further = {"type": point.type, "low": point.low, "high": point.high, "states": list(point.states)}
    return facts | {name: value for name, value in further.items() if value not in (None, "", [])}
