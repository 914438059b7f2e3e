"""Faults that open a ring, whatever its telegrams are: a segment that is cut, and a station without power."""

from typing import Final, Literal

from pydantic import Field

from fieldrig.faults import Timed

MASTER: Final = "master"
"""The segment that leaves the master, whatever the name of its device."""


class Break(Timed):
    """The fibre of one segment is cut: stations behind it hear nothing, and answers from before it can't come round."""

    what: Literal["break"]
    after: str = Field(description="the station that the segment leaves, or master")


class Off(Timed):
    """A station has no power: the ring is open there, unless the station has an optical bypass."""

    what: Literal["off"]
    station: str
