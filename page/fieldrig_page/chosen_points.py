"""The choice of two points of a device for its card: the values that a user in front of it would look at first."""

import re
from collections.abc import Collection, Iterator, Mapping
from typing import Any, Final

MOST: Final = 2
MEASURED: Final = (
    "level",
    "tension",
    "position",
    "speed",
    "temperature",
    "pressure",
    "flow",
    "torque",
    "frequency",
)
"""Words for the values of a part of a machine, the most telling first; a key may have a prefix such as `axis1.`."""
OBJECTS: Final = ("6064:00", "606C:00")
"""Position and velocity of a CiA 402 drive (CiA 402, 6064h and 606Ch)."""
STATES: Final = (
    *("state", "plc/state", "program.state", "ring.state", "display", "DiagMsg", "mode", "call", "running"),
    *("screen.1", "screen.2"),
)
"""Keys for what a controller is doing."""


OBJECT: Final = re.compile(r"[0-9A-F]{4}:[0-9A-F]{2}")
"""An object of an object dictionary; its name says more than its index."""


def label_of(key: str, about: str) -> str:
    """Return the words for a point on a card: its key, or the name of an object."""
    if about and OBJECT.fullmatch(key):
        return about
    return key.replace("_", " ")


def chosen(facts: Mapping[str, Mapping[str, Any]], named: Collection[str]) -> list[str]:
    """Return the keys of at most two points, given the facts of all points by key.

    Measured values come first, then states, then points that are `named` in the rig file because a wire is joined to
    them, then read-only values with a unit, and then any other.
    """
    return list(dict.fromkeys(_in_order(facts, named)))[:MOST]


def _in_order(facts: Mapping[str, Mapping[str, Any]], named: Collection[str]) -> Iterator[str]:
    for word in MEASURED:
        yield from (key for key in facts if key == word)
    for word in MEASURED:
        yield from (key for key in facts if _last_word(key) == word)
    yield from (key for key in (*OBJECTS, *STATES) if key in facts)
    plain = {name.partition(".")[0] for name in named}  # 6000:01.5 is a bit of 6000:01
    yield from (key for key in facts if key in named or key in plain)
    yield from (key for key, fact in facts.items() if fact.get("unit") and not fact.get("writable"))
    yield from facts


def _last_word(key: str) -> str:
    return key.replace("/", ".").rpartition(".")[2]
