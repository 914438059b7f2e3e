"""Each action just before and just after each edge of the scenario, where nothing is left to chance.

The changes of places come first, and then all other instants, ever closer to each other.
"""

from collections.abc import Iterator
from itertools import product
from typing import Final

from fieldrig_devices.search import run
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.strategy import Task

FIRST_STRIDE: Final = 64


class Sweep:
    ahead = 64

    def __init__(self, task: Task) -> None:
        plan, shard = task.plan, task.shard
        with task.bench.root.branch() as fresh:
            edges = fresh.call(run.edges, plan.edges, plan.scenario.length_ns)
        passes = [_around(edges.changes), *_closer(_around(edges.others))]
        self._passes = [instants[shard.number :: shard.of] for instants in passes]
        self._plan, self._changes, self._done = plan, len(edges.changes), 0
        self._left = self._all()

    def piece(self) -> Piece | None:
        return next(self._left, None)

    def take(self, played: Run) -> bool:
        self._done += 1
        return False

    def told(self) -> str:
        total = sum(map(len, self._passes)) * len(self._plan.actions)
        per_cent = 100 * self._done // total if total else 100
        return f"sweep: {self._done} of {total} runs ({per_cent} %), {self._changes} changes"

    def _all(self) -> Iterator[Piece]:
        for instants in self._passes:
            for at_ns, action in product(instants, self._plan.actions):
                yield Piece((action._replace(at_ns=at_ns),), at_ns, self._plan.scenario.length_ns)


def _around(instants: tuple[int, ...]) -> list[int]:
    return sorted({one for at_ns in instants for one in (at_ns - 1, at_ns + 1) if one >= 0})


def _closer(instants: list[int]) -> list[list[int]]:
    """Return the same instants in passes: every 64th, then those in the middle between them, and so on."""
    strides = [FIRST_STRIDE >> step for step in range(FIRST_STRIDE.bit_length())]
    return [instants[::FIRST_STRIDE], *(instants[stride :: 2 * stride] for stride in strides[1:])]
