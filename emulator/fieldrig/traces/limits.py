"""Instants that a format does not have, and the nearest ones that it has."""

from fieldrig.traces.oddities import Oddities


def from_1970(time_ns: int, odd: Oddities) -> int:
    """Return an instant for a format that has none before 1970."""
    if time_ns < 0:
        odd.report("times before 1970 become its first instant, as the format has no earlier")
    return max(time_ns, 0)
