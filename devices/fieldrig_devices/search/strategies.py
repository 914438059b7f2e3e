"""The strategies of a search; each makes runs until it is done, or until there is no time any more."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol

from fieldrig.clock import MS, S
from fieldrig.config.build import random_of
from fieldrig_devices.scenarios.act import Act, Schedule
from fieldrig_devices.search import run
from fieldrig_devices.search.plan import Plan
from fieldrig_devices.search.pool import Pool
from fieldrig_devices.search.run import Run

if TYPE_CHECKING:
    from fieldrig.virtual.branch import Branch

MOST_ACTS: Final = 4
"""Actions of one run of `swarm`, and of one piece of `archive`."""
PIECE_NS: Final = 2 * S
"""The length of a piece of `archive`."""
MOST_PIECES: Final = 10
"""The pieces that may follow one another."""
MOST_PARKED: Final = 64
FIRST_STRIDE: Final = 64
GRID_NS: Final = 1 * MS
"""Dice choose instants on this grid."""

Take = Callable[[Run], None]


class Shard(NamedTuple):
    """The part of a search that one of several machines does; together they do all of it."""

    number: int = 0
    of: int = 1


WHOLE: Final = Shard()


class Dice(Protocol):
    """The part of `random.Random` that strategies use."""

    def random(self) -> float: ...
    def randint(self, a: int, b: int) -> int: ...
    def randrange(self, start: int, stop: int) -> int: ...
    def choice(self, seq: Sequence[Act]) -> Act: ...


class World(NamedTuple):
    """The part that all strategies have in common."""

    plan: Plan
    root: "Branch"
    """The rig at the begin of the scenario, whose stage has begun."""
    workers: int
    seed: int
    shard: Shard
    may_start: Callable[[], bool]
    """Return whether there is time for one more run, which then has to be started."""
    take: Take


def sweep(world: World) -> str:
    """Try each action just before and just after each edge of the scenario, where nothing is left to chance.

    The changes of places come first, and then all other instants, ever closer to each other.  Returns how much is done.
    """
    plan, scenario = world.plan, world.plan.scenario
    with world.root.branch() as fresh:
        edges = fresh.call(run.edges, plan.edges, scenario.length_ns)
    passes = [_around(edges.changes), *_closer(_around(edges.others))]
    passes = [instants[world.shard.number :: world.shard.of] for instants in passes]
    total, done = sum(map(len, passes)) * len(plan.actions), 0
    with Pool(world.workers) as pool:
        for instants in passes:
            with world.root.branch() as trunk:
                for at_ns, action in product(instants, plan.actions):
                    if not (trunk.call(run.advance, at_ns) and world.may_start()):
                        break
                    acts = (action._replace(at_ns=at_ns),)
                    pool.start(trunk.branch(), world.take, run.go_on, acts, scenario.length_ns)
                    done += 1
                pool.finish()
    return f"sweep: {done} of {total} runs ({100 * done // total if total else 100} %), {len(edges.changes)} changes"


def _around(instants: tuple[int, ...]) -> list[int]:
    return sorted({one for at_ns in instants for one in (at_ns - 1, at_ns + 1) if one >= 0})


def _closer(instants: list[int]) -> list[list[int]]:
    """Return the same instants in passes: every 64th, then those in the middle between them, and so on."""
    strides = [FIRST_STRIDE >> step for step in range(FIRST_STRIDE.bit_length())]
    return [instants[::FIRST_STRIDE], *(instants[stride :: 2 * stride] for stride in strides[1:])]


def swarm(world: World) -> str:
    """Throw dice over random subsets of the actions; the baseline for the others."""
    count, number = 0, world.shard.number
    with Pool(world.workers) as pool:
        while world.may_start():
            acts = _thrown(random_of(f"swarm/{number}", world.seed), world.plan, 0, world.plan.scenario.length_ns)
            pool.start(world.root.branch(), world.take, run.go_on, acts, world.plan.scenario.length_ns)
            count, number = count + 1, number + world.shard.of
        pool.finish()
    return f"swarm: {count} runs"


def _thrown(dice: Dice, plan: Plan, from_ns: int, until_ns: int) -> Schedule:
    """Return up to MOST_ACTS actions of a random subset, at random instants."""
    kinds = [action for action in plan.actions if dice.random() < 0.5] or [dice.choice(plan.actions)]
    instants = sorted(
        dice.randrange(from_ns // GRID_NS, max(until_ns // GRID_NS, from_ns // GRID_NS + 1)) * GRID_NS
        for _ in range(dice.randint(1, MOST_ACTS))
    )
    return tuple(dice.choice(kinds)._replace(at_ns=at_ns) for at_ns in instants)


@dataclass(eq=False)
class _Parked:
    """A state of the machine from which the search goes on."""

    branch: "Branch"
    acts: Schedule
    at_ns: int
    pieces: int
    visits: int = 0


def archive(world: World) -> str:
    """Go on from parked branches in which the machine was in a new state, so that a bug with a history is found."""
    return _Archive(world).go()


class _Archive:
    def __init__(self, world: World) -> None:
        self._world = world
        self._dice = random_of(f"archive/{world.shard.number}", world.seed)
        self._parked = [_Parked(world.root, (), 0, 0)]
        self._seen: set[tuple[Any, ...]] = set()
        self._count = 0

    def go(self) -> str:
        try:
            with Pool(self._world.workers) as pool:
                while self._world.may_start():
                    self._start(pool)
                pool.finish()
        finally:
            for parked in self._parked[1:]:
                parked.branch.close()
        return f"archive: {self._count} runs, {len(self._seen)} states"

    def _start(self, pool: Pool) -> None:
        """Go on for a piece from the state that was visited least."""
        parked = min(self._parked, key=lambda one: (one.visits, self._dice.random()))
        parked.visits += 1
        self._count += 1
        until_ns = parked.at_ns + PIECE_NS
        acts = _thrown(self._dice, self._world.plan, parked.at_ns, until_ns)
        branch = parked.branch.branch()

        def take(result: Run) -> None:
            self._take(parked, branch, result)

        pool.start(branch, take, run.go_on_for, acts, until_ns, self._world.plan.states, is_kept=True)

    def _take(self, before: _Parked, branch: "Branch", result: Run) -> None:
        acts, new = (*before.acts, *result.acts), result.states - self._seen
        self._seen |= result.states
        self._world.take(result._replace(acts=acts))
        if not new or result.violations or before.pieces + 1 >= MOST_PIECES:
            branch.close()
            return
        self._parked.append(_Parked(branch, acts, result.length_ns, before.pieces + 1))
        if len(self._parked) > MOST_PARKED:
            self._drop()

    def _drop(self) -> None:
        """Let the state go that was visited most often; never the begin."""
        worst = max(self._parked[1:], key=lambda one: one.visits)
        self._parked.remove(worst)
        worst.branch.close()


STRATEGIES: Final[dict[str, Callable[[World], str]]] = {"sweep": sweep, "archive": archive, "swarm": swarm}
