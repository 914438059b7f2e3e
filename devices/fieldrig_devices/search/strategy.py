"""The common part of all strategies: each says which pieces are played, and learns from their outcomes.

What it says depends on the plan, the seed and the outcomes that it was given, in the order of their pieces; never on
how many are played at the same time, or on which of them ends first.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple, Protocol

from fieldrig.clock import MS
from fieldrig_devices.scenarios.act import Schedule
from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.choices import Choice, Dice, one_of
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.plan import Plan

MOST_ACTS: Final = 4
"""Actions that are thrown at a time."""
GRID_NS: Final = 1 * MS
"""Dice choose instants on this grid."""


class Shard(NamedTuple):
    """The part of a search that one of several machines does; together they do all of it."""

    number: int = 0
    of: int = 1


WHOLE: Final = Shard()


class Task(NamedTuple):
    """The part that all strategies have in common."""

    plan: Plan
    bench: Bench
    """The rig on this machine, for what has to be known before the first piece."""
    seed: int
    shard: Shard


class Strategy(Protocol):
    ahead: int
    """The number of pieces that are started before the outcome of the first of them is known; it is part of what makes
    a search what it is, so it does not depend on the number of workers, and should not be below that."""

    learns: bool
    """True if it goes on from the states of pieces."""

    def piece(self) -> Piece | None:
        """Return the next piece; None if there is none left."""

    def take(self, played: Run) -> bool:
        """Take the outcome of the first piece that is still open; return whether others may go on from its end."""

    def told(self) -> str:
        """Return what has been done, for a person."""


def thrown(dice: Dice, choices: Sequence[Choice], from_ns: int, until_ns: int) -> Schedule:
    """Return up to MOST_ACTS actions of a random subset, at random instants."""
    chosen = [choice for choice in choices if dice.random() < 0.5] or choices
    instants = sorted(
        dice.randrange(from_ns // GRID_NS, max(until_ns // GRID_NS, from_ns // GRID_NS + 1)) * GRID_NS
        for _ in range(dice.randint(1, MOST_ACTS))
    )
    return tuple(one_of(dice, chosen).thrown(dice, at_ns) for at_ns in instants)
