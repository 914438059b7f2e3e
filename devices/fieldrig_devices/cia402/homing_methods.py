"""The moves of each homing method.

Source: CiA 402-2, chapter 'homing mode', the figures of methods 1 to 14, 17 to 30, 33, 34; 35 and 37 have no moves.
Methods -1 to -4 belong to the makers; these are those of several makers that find a mechanical stop by the torque.
A method is a sequence of moves, each with a direction, a speed, and the edge of a switch that ends it.  Methods 1 to 14
are methods 17 to 30 followed by a move to the next encoder zero in the direction of the last move.  Where the figures
leave it open, the search for a switch is fast (6099h sub-index 1), and the search for its edge slow (sub-index 2).
"""

from typing import Final, NamedTuple

from fieldrig_devices.cia402.motor import Switch


class Move(NamedTuple):
    """One move of a homing method."""

    direction: int
    is_fast: bool
    """The speed is 6099h sub-index 1 if true, else sub-index 2."""
    switch: Switch | None
    """The switch whose edge ends the move, or None if the encoder zero ends it."""
    ends_when: bool = True
    turns_round: bool = False
    """True if the move reverses once at a limit switch."""
    finds_stop: bool = False
    """True if a mechanical stop ends the move, which shows by the torque, and not an edge or the encoder zero."""


_UP, _DOWN = 1, -1
LIMITS: Final = {_UP: Switch.POSITIVE_LIMIT, _DOWN: Switch.NEGATIVE_LIMIT}
"""The limit switch at the end of each direction."""

# The search for the home switch goes in one direction, or up to the limit switch and back.
TO_HOME_UP: Final = (Move(_UP, True, Switch.HOME),)
TO_HOME_DOWN: Final = (Move(_DOWN, True, Switch.HOME),)
SEARCH_UP: Final = (Move(_UP, True, Switch.HOME, turns_round=True),)
SEARCH_DOWN: Final = (Move(_DOWN, True, Switch.HOME, turns_round=True),)
# The lower edge is found moving down or up, the upper edge moving up or down.
LOWER_DOWN: Final = (Move(_DOWN, False, Switch.HOME, False),)
LOWER_UP: Final = (Move(_DOWN, True, Switch.HOME, False), Move(_UP, False, Switch.HOME))
UPPER_UP: Final = (Move(_UP, False, Switch.HOME, False),)
UPPER_DOWN: Final = (Move(_UP, True, Switch.HOME, False), Move(_DOWN, False, Switch.HOME))

EDGES: Final[dict[int, tuple[Move, ...]]] = {
    17: (Move(_DOWN, True, Switch.NEGATIVE_LIMIT), Move(_UP, False, Switch.NEGATIVE_LIMIT, False)),
    18: (Move(_UP, True, Switch.POSITIVE_LIMIT), Move(_DOWN, False, Switch.POSITIVE_LIMIT, False)),
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
"""Difference between the number of a method without the encoder zero and that of the same method with it."""


def _to_zero(direction: int) -> Move:
    return Move(direction, False, None)


def _to_stop(direction: int) -> Move:
    return Move(direction, False, None, finds_stop=True)


METHODS: Final[dict[int, tuple[Move, ...]]] = {
    **{number - _WITHOUT_ZERO: (*moves, _to_zero(moves[-1].direction)) for number, moves in EDGES.items()},
    **EDGES,
    33: (_to_zero(_DOWN),),
    34: (_to_zero(_UP),),
    35: (),
    37: (),
}

STANDARD_METHODS: Final = frozenset(METHODS)
"""The methods of the standard."""
BY_TORQUE: Final[dict[int, tuple[Move, ...]]] = {
    -1: (_to_stop(_DOWN), _to_zero(_UP)),
    -2: (_to_stop(_UP), _to_zero(_DOWN)),
    -3: (_to_stop(_UP),),
    -4: (_to_stop(_DOWN),),
}
"""Methods that find a mechanical stop."""
ALL_METHODS: Final = METHODS | BY_TORQUE
