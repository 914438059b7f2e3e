"""Goes on from the ends of pieces in which the machine was in a new state, so that a bug with a history is found.

It begins at instants along the nominal run.  What has led to a new state is also played to the end of the scenario
without anything else, as many a fault shows only when the scenario asks for the next thing.
"""

from collections import deque
from dataclasses import dataclass
from typing import Final

from fieldrig.clock import MS, S
from fieldrig.config.build import random_of
from fieldrig.points.values import counted
from fieldrig_devices.scenarios.act import Schedule
from fieldrig_devices.search.piece import Piece, Run, World
from fieldrig_devices.search.strategy import Task, thrown

PIECE_NS: Final = 2 * S
PIECES: Final = 8
"""Pieces along the nominal run of a long scenario."""
MOST_PIECES: Final = 10
"""The pieces that may follow one another."""
MOST_STATES: Final = 48
UNUSUAL: Final = 0.25
"""How often one action comes again and again, and how often all of a piece come at nearly the same time."""
MOST_REPEATS: Final = 8
NEAR_NS: Final = 20 * MS


@dataclass(eq=False)
class _State:
    """A state of the machine from which the search goes on."""

    world: World
    acts: Schedule
    at_ns: int
    pieces: int
    visits: int = 0


class Archive:
    ahead = 16
    learns = True

    def __init__(self, task: Task) -> None:
        self._task = task
        self._dice = random_of(f"archive/{task.shard.number}", task.seed)
        length_ns = task.plan.scenario.length_ns
        self._is_mastered = task.plan.scenario.master is not None
        """True if no branch can be parked, so that each piece is played to the end at once."""
        self._piece_ns = max(PIECE_NS, length_ns // PIECES)
        begins = range(0, length_ns, self._piece_ns)
        self._known = [_State(world, (), at_ns, 0) for world in task.plan.worlds for at_ns in begins]
        self._begins = len(self._known)
        self._open: deque[_State | None] = deque()
        """The states that the open pieces go on from; none for one that is played to the end."""
        self._ends: deque[Piece] = deque()
        """The pieces that play on to the end of the scenario what has led to new states."""
        self._seen: set[bytes] = set()
        self._marks = 0
        """The marks that any piece has passed, as the bytes of a number."""
        self._count = 0

    def piece(self) -> Piece:
        """Play on to the end what led to a new state, or go on for a piece from the state that was visited least."""
        if self._ends:
            self._open.append(None)
            return self._ends.popleft()
        state = min(self._known, key=lambda one: (one.visits, self._dice.random()))
        state.visits += 1
        self._open.append(state)
        until_ns = state.at_ns + self._piece_ns
        acts = self._thrown(state.at_ns, until_ns)
        if self._is_mastered:
            until_ns = max(until_ns, self._task.plan.scenario.length_ns)
        return Piece((*state.acts, *acts), state.at_ns, until_ns, is_whole=False, world=state.world)

    def take(self, played: Run) -> bool:
        before = self._open.popleft()
        self._count += 1
        is_new = self._is_new(played)
        if before is None or not is_new or played.violations or played.refused or before.pieces + 1 >= MOST_PIECES:
            return False
        length_ns, at_ns = self._task.plan.scenario.length_ns, before.at_ns + self._piece_ns
        if at_ns < length_ns and not self._is_mastered:
            self._ends.append(Piece(played.acts, at_ns, length_ns, world=played.world))
        self._known.append(_State(before.world, played.acts, at_ns, before.pieces + 1))
        if len(self._known) > MOST_STATES:
            # The state that was visited most often goes; never a begin.
            self._known.remove(max(self._known[self._begins :], key=lambda one: one.visits))
        return True

    def _is_new(self, played: Run) -> bool:
        """Note what a piece has seen, and return whether there is anything for the first time."""
        marks = int.from_bytes(played.marks, "little")
        is_new = not played.states <= self._seen or bool(marks & ~self._marks)
        self._seen |= played.states
        self._marks |= marks
        return is_new

    def _thrown(self, from_ns: int, until_ns: int) -> Schedule:
        """Return up to MOST_ACTS actions; sometimes all at nearly the same time, or one of them again and again."""
        dice = self._dice
        acts = thrown(dice, self._task.bench.choices, from_ns, until_ns)
        how = dice.random()
        if how < UNUSUAL:
            begin_ns = acts[0].at_ns
            acts = tuple(act._replace(at_ns=begin_ns + (act.at_ns - begin_ns) % NEAR_NS) for act in acts)
        elif how < 2 * UNUSUAL:
            period_ns = (until_ns - from_ns) // dice.randint(2, MOST_REPEATS) // MS * MS
            acts = tuple(acts[0]._replace(at_ns=at_ns) for at_ns in range(from_ns, until_ns, period_ns))
        return tuple(sorted(acts, key=lambda act: act.at_ns))

    def told(self) -> str:
        runs, states = counted(self._count, "run"), counted(len(self._seen), "state")
        return f"archive: {runs}, {states}, {self._marks.bit_count()} branches of programs"
