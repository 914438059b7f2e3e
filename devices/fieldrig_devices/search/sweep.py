"""Each action just before and just after each edge of the scenario, where nothing is left to chance.

What needs no instant comes first: other worlds, and faults that wait for a condition.  Then it goes in rounds, each of
which looks closer than the one before: round n has each action 2^n times in the run, at the nth edge of each kind (a
place that goes from one value to another), and at twice as many of all other instants as the round before, spread over
the scenario.  Where there are many actions, each instant gets some of them at a time, so that what is done of a sweep
that ends early is spread over all instants and all actions.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice, zip_longest
from typing import Final

from fieldrig.clock import MS
from fieldrig.points.values import counted
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.search.minimal import DURATION
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.strategy import Task

FIRST: Final = 8
"""The number of other instants in the first round."""
REPEATS: Final = (2, 4, 8, 16)
"""How often an action comes in a run, by round."""
AT_ONCE: Final = 8
"""Actions that an instant gets at a time, and runs with one action between two with several."""


class Sweep:
    ahead = 64
    learns = False

    def __init__(self, task: Task) -> None:
        plan, shard = task.plan, task.shard
        self._length_ns, self._worlds = plan.scenario.length_ns, plan.worlds
        nominal = task.bench.nominal
        actions = [act for choice in task.bench.choices for act in choice.all(0)]
        self._actions = [act for act in actions if not _waits(act)]
        awaited = [act for act in actions if _waits(act)]
        self._alone = [Piece((), 0, self._length_ns, world=world) for world in self._worlds[1:]]
        self._alone += [Piece((act,), 0, self._length_ns, world=world) for world in self._worlds for act in awaited]
        others = self._around(nominal.others)
        self._rounds = [
            (self._repeated(number), instants[shard.number :: shard.of])
            for number, instants in enumerate(_rounds(self._nth_changes(nominal.changes), _closer(others)))
        ]
        self._shard = shard
        self._changes, self._done = sum(map(len, nominal.changes)), 0
        self._left = self._all()

    def piece(self) -> Piece | None:
        return next(self._left, None)

    def take(self, played: Run) -> bool:
        self._done += 1
        return False

    def told(self) -> str:
        total = len(self._mine(self._alone)) + len(self._worlds) * sum(
            len(self._mine(repeated)) + len(instants) * len(self._actions) for repeated, instants in self._rounds
        )
        per_cent = 100 * self._done // total if total else 100
        return f"sweep: {self._done} of {total} runs ({per_cent} %), {counted(self._changes, 'change')}"

    def _all(self) -> Iterator[Piece]:
        yield from self._mine(self._alone)
        for world in self._worlds:
            for repeated, instants in self._rounds:
                singles = self._over(instants, world)
                for piece in self._mine(repeated):
                    yield piece._replace(world=world)
                    yield from islice(singles, AT_ONCE)
                yield from singles

    def _mine(self, pieces: Sequence[Piece]) -> Sequence[Piece]:
        return pieces[self._shard.number :: self._shard.of]

    def _repeated(self, number: int) -> list[Piece]:
        """Return each action several times in the run, at the same distances, unless it would not end between them."""
        if number >= len(REPEATS):
            return []
        period_ns = self._length_ns // REPEATS[number]
        trains = [
            tuple(act._replace(at_ns=(2 * n + 1) * period_ns // 2) for n in range(REPEATS[number]))
            for act in self._actions
            if _lasts_ns(act) * 4 <= period_ns * 3
        ]
        return [Piece(acts, 0, self._length_ns) for acts in trains]

    def _over(self, instants: Sequence[int], world: tuple[str, ...]) -> Iterator[Piece]:
        """Yield each action at each instant."""
        rounds = -(-len(self._actions) // AT_ONCE)
        for turn in range(rounds):
            for number, at_ns in enumerate(instants):
                for act in self._actions[(turn + number) % rounds :: rounds]:
                    yield Piece((act._replace(at_ns=at_ns),), at_ns, self._length_ns, world=world)

    def _nth_changes(self, kinds: Sequence[Sequence[int]]) -> list[list[int]]:
        """Return the instants around the first change of each kind, around the second one of each, and so on."""
        longest = max(map(len, kinds), default=0)
        return [self._around([kind[number] for kind in kinds if number < len(kind)]) for number in range(longest)]

    def _around(self, instants: Sequence[int]) -> list[int]:
        near = {one for at_ns in instants for one in (at_ns - 1, at_ns + 1)}
        return sorted(one for one in near if 0 <= one < self._length_ns)


def _rounds(changes: Sequence[Sequence[int]], others: Sequence[Sequence[int]]) -> Iterator[list[int]]:
    """Yield the instants of each round, none of them twice."""
    seen: set[int] = set()
    for some, more in zip_longest(changes, others, fillvalue=()):
        new = {*some, *more} - seen
        yield sorted(new)
        seen |= new


def _closer(instants: Sequence[int]) -> list[Sequence[int]]:
    """Return the same instants in passes: some that are spread over all, then those in the middle between them."""
    stride = 1
    while len(instants) > FIRST * stride:
        stride *= 2
    passes = [instants[::stride]]
    while stride > 1:
        passes.append(instants[stride // 2 :: stride])
        stride //= 2
    return passes


def _lasts_ns(act: Act) -> int:
    """Return the duration of a key or a fault."""
    return act.hold_ns + (int(float(act.value.get(DURATION, 0)) * MS) if isinstance(act.value, Mapping) else 0)


def _waits(act: Act) -> bool:
    """True for a fault that begins at a condition, whenever it is given."""
    return act.verb == "fault" and isinstance(act.value, Mapping) and "when" in act.value
