"""The ways of each homing method.

Source: CiA 402-2, chapter 'homing mode', the figures of methods 1 to 14, 17 to 30, 33, 34; 35 and 37 have no way.
A method is a row of ways, each with a direction, a speed and the edge of a switch that ends it.  Methods 1 to 14 are
those of 17 to 30 and then the next zero of the encoder in the direction of the last way.  Where figures leave it open,
a switch is looked for fast (6099h sub-index 1), and its edge is found slowly (sub-index 2).
"""

from typing import Final, NamedTuple

from fieldrig_devices.cia402.motor import Switch


class Way(NamedTuple):
    direction: int
    is_fast: bool
    """6099h sub-index 1, else 2."""
    switch: Switch | None
    """None: the encoder's zero."""
    ends_when: bool = True
    turns_round: bool = False
    """At a limit switch the way is gone on with in the other direction, once."""


_UP, _DOWN = 1, -1
LIMITS: Final = {_UP: Switch.POSITIVE_LIMIT, _DOWN: Switch.NEGATIVE_LIMIT}
"""What stands at the end of a direction."""

# The home switch is looked for in one direction, or up to the limit switch and back.
TO_HOME_UP: Final = (Way(_UP, True, Switch.HOME),)
TO_HOME_DOWN: Final = (Way(_DOWN, True, Switch.HOME),)
SEARCH_UP: Final = (Way(_UP, True, Switch.HOME, turns_round=True),)
SEARCH_DOWN: Final = (Way(_DOWN, True, Switch.HOME, turns_round=True),)
# Its lower edge is found downwards or upwards, its upper edge upwards or downwards.
LOWER_DOWN: Final = (Way(_DOWN, False, Switch.HOME, False),)
LOWER_UP: Final = (Way(_DOWN, True, Switch.HOME, False), Way(_UP, False, Switch.HOME))
UPPER_UP: Final = (Way(_UP, False, Switch.HOME, False),)
UPPER_DOWN: Final = (Way(_UP, True, Switch.HOME, False), Way(_DOWN, False, Switch.HOME))

EDGES: Final[dict[int, tuple[Way, ...]]] = {
    17: (Way(_DOWN, True, Switch.NEGATIVE_LIMIT), Way(_UP, False, Switch.NEGATIVE_LIMIT, False)),
    18: (Way(_UP, True, Switch.POSITIVE_LIMIT), Way(_DOWN, False, Switch.POSITIVE_LIMIT, False)),
    19: TO_HOME_UP + LOWER_DOWN,
    20: TO_HOME_UP + LOWER_UP,
    21: TO_HOME_DOWN + UPPER_UP,
    22: TO_HOME_DOWN + UPPER_DOWN,
    23: SEARCH_UP + LOWER_DOWN,
    24: SEARCH_UP + LOWER_UP,
    25: SEARCH_UP + UPPER_DOWN,
    26: SEARCH_UP + UPPER_UP,
    27: SEARCH_DOWN + UPPER_UP,
    28: SEARCH_DOWN + UPPER_DOWN,
    29: SEARCH_DOWN + LOWER_UP,
    30: SEARCH_DOWN + LOWER_DOWN,
}
_WITHOUT_ZERO: Final = 16
"""How much higher the number of a method is that doesn't look for the encoder's zero."""


def _to_zero(direction: int) -> Way:
    return Way(direction, False, None)


METHODS: Final[dict[int, tuple[Way, ...]]] = {
    **{number - _WITHOUT_ZERO: (*ways, _to_zero(ways[-1].direction)) for number, ways in EDGES.items()},
    **EDGES,
    33: (_to_zero(_DOWN),),
    34: (_to_zero(_UP),),
    35: (),
    37: (),
}
