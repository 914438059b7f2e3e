"""The rig of a plan at the begin of its scenario, with branches on the way: what plays a piece in this process."""

from collections import OrderedDict
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Final, Self

from fieldrig.coverage.collecting import collecting
from fieldrig.coverage.places import Place
from fieldrig.errors import ConfigError, GoneError
from fieldrig.virtual.branch import Branch
from fieldrig.virtual.rig import Rig
from fieldrig_devices.scenarios.act import RefusedActError
from fieldrig_devices.scenarios.checks import check, refused_at
from fieldrig_devices.scenarios.play import Played
from fieldrig_devices.scenarios.rig_of_scenario import config_of
from fieldrig_devices.search import run
from fieldrig_devices.search.choices import Choice
from fieldrig_devices.search.piece import Piece, Run, World, acts_text
from fieldrig_devices.search.plan import Plan, in_world
from fieldrig_devices.search.plan_checks import check_alone, check_plan
from fieldrig_devices.search.run import Nominal
from fieldrig_devices.search.trunk import Trunk
from fieldrig_devices.search.vary import choices_of

if TYPE_CHECKING:
    from types import TracebackType

MOST_LOST: Final = 2
"""Times that a piece is played again whose process was ended from outside."""
MOST_PARKED: Final = 64
"""Branches that are kept at the ends of pieces; those that were used least recently go."""


class Bench:
    """Plays pieces; it has no need of anything that another worker has.

    From `plan` alone it makes what a piece begins with.
    """

    def __init__(self, plan: Plan) -> None:
        """ConfigError or RigError for a rig that cannot be loaded, or that does not have what the plan names."""
        self.plan = plan
        self._worlds: dict[World, _Standing] = {}
        self._parked: OrderedDict[_Key, Branch] = OrderedDict()
        self._cpu_s = 0.0
        self._first = self._standing(())

    @property
    def rig(self) -> Rig:
        """The rig at the begin of the scenario, which has not begun; nothing may run it."""
        return self._first.rig

    @property
    def root(self) -> Branch:
        """The first world at the begin of the scenario."""
        return self._first.root

    def check(self) -> None:
        """ConfigError, with every mistake, for what no rig of the plan has."""
        for world in self.plan.worlds:
            _check_world(self.plan, world)
        _ = self.choices

    @cached_property
    def choices(self) -> tuple[Choice, ...]:
        """The things that may happen.  ConfigError, with every mistake, for what the rig does not have."""
        with self.rig.branch() as scratch:
            refused = scratch.call(check_plan, self.plan)
        for path, act in refused:
            with self.rig.branch() as scratch:
                scratch.call(check_alone, self.plan, path, act)
        with self.rig.branch() as scratch:
            return scratch.call(choices_of, self.plan.vary)

    @property
    def places(self) -> Sequence[tuple[int, Place]]:
        """The places of all programs, each with the number of its mark in `Run.marks`."""
        return self._first.places

    @cached_property
    def nominal(self) -> Nominal:
        """The run of the first world without any action besides."""
        with self.root.branch() as branch:
            try:
                found = branch.call(run.nominal, self.plan.edges, self.plan.scenario.length_ns)
            except RefusedActError as wrong:
                raise refused_at(self.plan.scenario, wrong) from wrong
        self._cpu_s += found.cpu_s
        return found

    @property
    def cpu_s(self) -> float:
        """The processor time in seconds that went into nominal runs, and into what `play` has played."""
        return self._cpu_s + sum(standing.trunk.cpu_s for standing in self._worlds.values())

    def play(self, piece: Piece) -> Run:
        """Play a piece."""
        branch = self.start(piece)
        try:
            branch, played = self.result(branch, piece)
        except BaseException:
            branch.close()
            raise
        self._cpu_s += played.cpu_s
        self.park(branch, piece, played)
        return played

    def result(self, branch: Branch, piece: Piece) -> tuple[Branch, Run]:
        """Return the outcome of a piece with its branch, which is another one if the first was ended from outside."""
        for _ in range(MOST_LOST):
            try:
                return branch, branch.result()
            except GoneError:
                branch = self.start(piece)
        return branch, branch.result()

    def told(self, piece: Piece) -> Played:
        """Play a whole piece with all that a report needs."""
        for _ in range(MOST_LOST):
            with suppress(GoneError):
                return self._told(piece)
        return self._told(piece)

    def _told(self, piece: Piece) -> Played:
        with self._standing(piece.world).rig.branch() as branch:
            told: Played = branch.call(run.play_told, _in_world(self.plan, piece.world), piece)
            return told

    def start(self, piece: Piece) -> Branch:
        """Start a piece in a branch of its own; `Branch.result` gives the `Run`, and `park` takes the branch back."""
        try:
            branch = self._nearest(piece).branch()
        except GoneError:
            parked = self._parked.pop(_begin_of(piece), None)
            if parked is not None:
                parked.close()
            self._standing(piece.world).trunk.begin_again()
            branch = self._nearest(piece).branch()
        branch.start(run.play_piece, piece)
        return branch

    def park(self, branch: Branch, piece: Piece, played: Run) -> None:
        """Keep a branch whose piece has ended if another one may go on from there."""
        if piece.is_whole or played.violations or played.refused or self.plan.scenario.master is not None:
            branch.close()
            return
        self._parked[_end_of(played)] = branch
        if len(self._parked) > MOST_PARKED:
            self._parked.popitem(last=False)[1].close()

    def drop(self, played: Run) -> None:
        """Let the branch at the end of this piece go: no other piece goes on from there."""
        branch = self._parked.pop(_end_of(played), None)
        if branch is not None:
            branch.close()

    def close(self) -> None:
        for branch in self._parked.values():
            branch.close()
        for standing in reversed(list(self._worlds.values())):
            standing.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: "type[BaseException] | None", fault: BaseException | None, tb: "TracebackType | None"
    ) -> None:
        self.close()

    def _standing(self, world: World) -> "_Standing":
        """Return the rig with the overrides of a world, which is built if it is not there."""
        if world not in self._worlds:
            self._worlds[world] = _Standing(_in_world(self.plan, world))
        return self._worlds[world]

    def _nearest(self, piece: Piece) -> Branch:
        """Return a branch that has done the most of what comes before a piece, and nothing else."""
        standing, before = self._standing(piece.world), piece.before
        if self.plan.scenario.master is not None:
            return standing.root  # a master begins with the scenario, and has threads that no branch can have
        if not before and piece.from_ns:
            return standing.trunk.at(piece.from_ns)
        key = _begin_of(piece)
        if key in self._parked:
            self._parked.move_to_end(key)
            return self._parked[key]
        return standing.trunk.before(_first_ns(piece))


_Key = tuple[World, str, int]


def _begin_of(piece: Piece) -> _Key:
    return piece.world, acts_text(piece.before), piece.from_ns


def _end_of(played: Run) -> _Key:
    return played.world, acts_text(played.acts), played.length_ns


def _check_world(plan: Plan, world: World) -> None:
    try:
        config_of(in_world(plan.scenario, world))
    except ConfigError as wrong:
        if not world:
            raise
        words = f"in the world {', '.join(world)} of the plan: "
        raise ConfigError([replace(mistake, what=words + mistake.what) for mistake in wrong.mistakes]) from None


def _in_world(plan: Plan, world: World) -> Plan:
    return plan._replace(scenario=in_world(plan.scenario, world))


def _first_ns(piece: Piece) -> int:
    """Return an instant until which a piece is the nominal run, and no states on the way are asked for."""
    begin_ns = piece.until_ns if piece.is_whole else piece.from_ns
    return min((begin_ns, *(0 if act.when else act.at_ns for act in piece.acts))) if piece.acts else 0


class _Standing:
    """A rig at the begin of the scenario, and the trunk: branches along its nominal run."""

    def __init__(self, plan: Plan) -> None:
        scenario = plan.scenario
        if scenario.master is not None:
            from fieldrig.master_time.program import load_libraries  # most programs are the rig's

            load_libraries(scenario.master)  # before the rig: some have threads, such as those of numpy
        with ExitStack() as stack:
            collector = stack.enter_context(collecting(is_written=False))
            self.rig = stack.enter_context(Rig(config_of(scenario)))
            self.rig.run_until(scenario.after_ns)
            with self.rig.branch() as scratch:
                scratch.call(check, scenario)
            self.root = self.rig.branch()
            self.root.call(run.begin, plan)
            self.places, first = list[tuple[int, Place]](), 0
            for one in collector.programs:
                self.places += [(first + mark, place) for mark, place in one.places]
                first += len(one.hits)
            self.trunk = Trunk(self.root, scenario.length_ns)
            self._stack = stack.pop_all()

    def close(self) -> None:
        self._stack.close()
