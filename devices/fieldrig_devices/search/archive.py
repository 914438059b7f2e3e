"""Goes on from the ends of pieces in which the machine was in a new state, so that a bug with a history is found."""

from collections import deque
from dataclasses import dataclass
from typing import Final

from fieldrig.clock import S
from fieldrig.config.build import random_of
from fieldrig_devices.scenarios.act import Schedule
from fieldrig_devices.search.eye import State
from fieldrig_devices.search.piece import Piece, Run, World
from fieldrig_devices.search.strategy import Task, thrown

PIECE_NS: Final = 2 * S
MOST_PIECES: Final = 10
"""The pieces that may follow one another."""
MOST_STATES: Final = 48


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

    def __init__(self, task: Task) -> None:
        self._task = task
        self._dice = random_of(f"archive/{task.shard.number}", task.seed)
        self._known = [_State(world, (), 0, 0) for world in task.plan.worlds]
        self._begins = len(self._known)
        self._open: deque[_State] = deque()
        """The states that the open pieces go on from."""
        self._seen: set[State] = set()
        self._marks = 0
        """The marks that any piece has passed, as the bytes of a number."""
        self._count = 0

    def piece(self) -> Piece:
        """Go on for a piece from the state that was visited least."""
        state = min(self._known, key=lambda one: (one.visits, self._dice.random()))
        state.visits += 1
        self._open.append(state)
        until_ns = state.at_ns + PIECE_NS
        acts = thrown(self._dice, self._task.bench.choices, state.at_ns, until_ns)
        return Piece((*state.acts, *acts), state.at_ns, until_ns, is_whole=False, world=state.world)

    def take(self, played: Run) -> bool:
        before = self._open.popleft()
        self._count += 1
        is_new = self._is_new(played)
        if not is_new or played.violations or played.refused or before.pieces + 1 >= MOST_PIECES:
            return False
        self._known.append(_State(before.world, played.acts, played.length_ns, before.pieces + 1))
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

    def told(self) -> str:
        return f"archive: {self._count} runs, {len(self._seen)} states, {self._marks.bit_count()} branches of programs"
