"""A search: a control run, the strategies, and for each property the smallest way in which it does not hold."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

from fieldrig.errors import RigError
from fieldrig.system.stopwatch import Stopwatch
from fieldrig.virtual.readings import seconds
from fieldrig_devices.scenarios.act import Schedule
from fieldrig_devices.scenarios.property import Violation
from fieldrig_devices.search import run
from fieldrig_devices.search.corpus import Corpus, Finding
from fieldrig_devices.search.minimal import minimal
from fieldrig_devices.search.plan import Plan
from fieldrig_devices.search.run import Run
from fieldrig_devices.search.strategies import STRATEGIES, WHOLE, Shard, World

if TYPE_CHECKING:
    from fieldrig.virtual.branch import Branch
    from fieldrig.virtual.rig import Rig

MOST_SHRUNK: Final = 3
"""Findings of one property that are made small; further ones are most likely the same."""


class Limits(NamedTuple):
    """The end of a search: whichever comes first."""

    budget_s: float
    """The time of the host."""
    most_runs: int


class Search:
    def __init__(self, rig: "Rig", plan: Plan, corpus: Corpus, workers: int, seed: int, shard: Shard = WHOLE) -> None:
        """`rig` is at the begin of the scenario."""
        self._rig, self._plan, self._corpus = rig, plan, corpus
        self._workers, self._seed, self._shard = workers, seed, shard
        self.runs = 0
        self._failing: dict[str, list[Run]] = {}
        """The runs in which a property does not hold, by its name."""

    def go(self, strategies: Sequence[str], limits: Limits, tell: Callable[[str], None]) -> None:
        """Search.  RigError if the scenario does not hold without any action besides."""
        self._check_control()
        watch = Stopwatch()
        for number, name in enumerate(strategies, 1):
            until_s = limits.budget_s * number / len(strategies)
            with self._rig.branch() as root:
                root.call(run.begin, self._plan.scenario)
                tell(STRATEGIES[name](self._world(root, name, watch, until_s, limits.most_runs)))
        for property_name, failing in self._failing.items():
            for one in sorted(failing, key=lambda one: len(one.acts))[:MOST_SHRUNK]:
                self._shrink(property_name, one)

    def _world(self, root: "Branch", strategy: str, watch: Stopwatch, until_s: float, most_runs: int) -> World:
        def may_start() -> bool:
            may = watch.seconds < until_s and self.runs < most_runs
            self.runs += may
            return may

        def take(result: Run) -> None:
            self._take(result, strategy)

        return World(self._plan, root, self._workers, self._seed, self._shard, may_start, take)

    def _check_control(self) -> None:
        with self._rig.branch() as control:
            played = control.call(run.play_all, self._plan.scenario, (), self._plan.scenario.length_ns)
        for wrong in played.violations:
            what = f"{wrong.property} does not hold without any action besides: at {seconds(wrong.at_ns)} {wrong.what}"
            raise RigError(what, "fix the property or the scenario first; `fieldrig scenario run` shows it as well")

    def _take(self, result: Run, strategy: str) -> None:
        self._corpus.add(result, strategy)
        for violation in result.violations:
            self._failing.setdefault(violation.property, []).append(result)

    def _shrink(self, property_name: str, failing: Run) -> None:
        """Note the fewest actions with which a property does not hold."""
        length_ns = max(failing.length_ns, self._plan.scenario.length_ns)

        def broken(acts: Schedule) -> Violation | None:
            with root.branch() as branch:
                played = branch.call(run.play_all, self._plan.scenario, acts, length_ns)
            return next((one for one in played.violations if one.property == property_name), None)

        with self._rig.branch() as root:
            acts = minimal(failing.acts, lambda some: broken(some) is not None)
            violation = broken(acts)
        assert violation is not None, "a run is the same each time"
        at_ns, what = violation.at_ns, violation.what
        self._corpus.note(Finding(0, property_name, acts, failing.acts, length_ns, at_ns, what))
