"""Each action just before and just after each edge of the scenario, where nothing is left to chance.

What needs no instant comes first: other worlds, and faults that wait for a condition.  Then come the changes of places,
and then all other instants, ever closer to each other.  Where there are many actions, each instant gets some of them at
a time, so that what is done of a sweep that ends early is spread over all instants and all actions.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.search import run
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.strategy import Task

FIRST_STRIDE: Final = 64
AT_ONCE: Final = 8
"""Actions that an instant gets at a time."""


class Sweep:
    ahead = 64

    def __init__(self, task: Task) -> None:
        plan, shard = task.plan, task.shard
        self._length_ns, self._worlds = plan.scenario.length_ns, plan.worlds
        with task.bench.root.branch() as fresh:
            edges = fresh.call(run.edges, plan.edges, self._length_ns)
        passes = [self._around(edges.changes), *_closer(self._around(edges.others))]
        self._passes = [instants[shard.number :: shard.of] for instants in passes]
        actions = [act for choice in task.bench.choices for act in choice.all(0)]
        self._actions = [act for act in actions if not _waits(act)]
        awaited = [act for act in actions if _waits(act)]
        alone = [Piece((), 0, self._length_ns, world=world) for world in self._worlds[1:]]
        alone += [Piece((act,), 0, self._length_ns, world=world) for world in self._worlds for act in awaited]
        self._alone = alone[shard.number :: shard.of]
        self._changes, self._done = len(edges.changes), 0
        self._left = self._all()

    def piece(self) -> Piece | None:
        return next(self._left, None)

    def take(self, played: Run) -> bool:
        self._done += 1
        return False

    def told(self) -> str:
        total = len(self._alone) + len(self._worlds) * sum(map(len, self._passes)) * len(self._actions)
        per_cent = 100 * self._done // total if total else 100
        return f"sweep: {self._done} of {total} runs ({per_cent} %), {self._changes} changes"

    def _all(self) -> Iterator[Piece]:
        yield from self._alone
        for world in self._worlds:
            for instants in self._passes:
                yield from self._over(instants, world)

    def _over(self, instants: Sequence[int], world: tuple[str, ...]) -> Iterator[Piece]:
        """Yield each action at each instant."""
        rounds = -(-len(self._actions) // AT_ONCE)
        for turn in range(rounds):
            for number, at_ns in enumerate(instants):
                for act in self._actions[(turn + number) % rounds :: rounds]:
                    yield Piece((act._replace(at_ns=at_ns),), at_ns, self._length_ns, world=world)

    def _around(self, instants: tuple[int, ...]) -> list[int]:
        near = {one for at_ns in instants for one in (at_ns - 1, at_ns + 1)}
        return sorted(one for one in near if 0 <= one < self._length_ns)


def _closer(instants: list[int]) -> list[list[int]]:
    """Return the same instants in passes: every 64th, then those in the middle between them, and so on."""
    strides = [FIRST_STRIDE >> step for step in range(FIRST_STRIDE.bit_length())]
    return [instants[::FIRST_STRIDE], *(instants[stride :: 2 * stride] for stride in strides[1:])]


def _waits(act: Act) -> bool:
    """True for a fault that begins at a condition, whenever it is given."""
    return act.verb == "fault" and isinstance(act.value, Mapping) and "when" in act.value
