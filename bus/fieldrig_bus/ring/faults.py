"""Faults of a ring, whatever its telegrams are: a segment that is cut, and a station without power.

A fault says where (a segment, by the station that it leaves; or a station), what, when and for how long (`start_ms`,
`duration_ms`) and how often (`nth`, `count`, `probability`).  It ends when it is cleared, or after its duration.
"""

from typing import Final, Literal

from pydantic import Field

from fieldrig.faults.faults import Timed

MASTER: Final = "master"
"""The segment that leaves the master, whatever the name of its device."""


class Break(Timed):
    """The fibre of one segment is cut: stations behind it hear nothing, and answers from before it are lost."""

    what: Literal["break"]
    after: str = Field(description="the station that the segment leaves, or master")


class Off(Timed):
    """A station has no power: the ring is open there, unless the station has an optical bypass."""

    what: Literal["off"]
    station: str


def place_of(fault: Timed) -> tuple[str, str]:
    """Return the key that says where, and the station that it names."""
    for key in ("after", "station"):
        name = getattr(fault, key, None)
        if isinstance(name, str):
            return key, name
    raise AssertionError(f"{fault} has no place")
