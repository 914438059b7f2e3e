"""Runs the suite: in virtual time as an outside member of a rig, or in real time as a tool on a bus."""

from collections.abc import Callable, Iterable, Sequence
from fnmatch import fnmatchcase
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fieldrig.bus import Bus
from fieldrig.clock import Clock, S
from fieldrig.errors import UsageError
from fieldrig.hub.tool_member import OnEnd, join
from fieldrig.link import Link
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance import cases as _families
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import CASES, Case
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.line import Line
from fieldrig_devices.conformance.options import Options
from fieldrig_devices.conformance.report import Report
from fieldrig_devices.conformance.suite import Result, Suite

assert _families  # the import registers the cases
MEMBER = "conform"
OnResult = Callable[[Result], None]
OnProgress = Callable[[str], None]
"""Takes what the suite is doing, while a case takes long."""
QUIET_NS = 10 * S
"""Time without a result after which the progress is reported, and again after the same time."""


def choose(patterns: Iterable[str]) -> list[Case]:
    """Return the cases whose number, name or family matches a pattern, or all.  Raises UsageError if none does."""
    wanted = [pattern.casefold() for pattern in patterns]
    every = sorted(CASES.values(), key=lambda case: case.order)
    chosen = [case for case in every if not wanted or any(_fits(case, pattern) for pattern in wanted)]
    for pattern in wanted:
        if not any(_fits(case, pattern) for case in every):
            raise UsageError(
                f"no case matches {pattern}", "expected patterns such as 2.7, '2.*', 'SDO 07', SDO or 'PDO 2*'"
            )
    return chosen


def conform_virtual(
    rig: Rig,
    bus: str,
    eds: Description,
    cases: Sequence[Case],
    options: Options | None = None,
    on_result: OnResult | None = None,
    date: str = "",
    on_progress: OnProgress | None = None,
) -> Report:
    """Run the cases on a node of a rig in virtual time; the rest of the rig runs, too."""
    node = rig.attach(MEMBER)
    run = _Run(eds, cases, options or Options(), on_result, on_progress)
    run.start(node.clock, node.link(bus), run.end)
    while not run.is_ended and rig.step():
        pass
    return run.report(f"{bus} of {rig.config.name} (virtual time)", date)


def conform_real(
    bus: Bus[Any],
    folder: Path,
    eds: Description,
    cases: Sequence[Case],
    options: Options | None = None,
    on_result: OnResult | None = None,
    date: str = "",
    bus_text: str = "",
    on_progress: OnProgress | None = None,
) -> Report:
    """Run the cases on a node of a real-time bus.  Raises BusError if the bus isn't available."""
    run = _Run(eds, cases, options or Options(), on_result, on_progress)
    join(bus, folder, MEMBER, run.start)
    return run.report(bus_text or bus.name, date)


class _Run:
    def __init__(
        self,
        eds: Description,
        cases: Sequence[Case],
        options: Options,
        on_result: OnResult | None,
        on_progress: OnProgress | None,
    ) -> None:
        self._eds, self._cases, self._options, self._on_result = eds, cases, options, on_result
        self._on_progress = on_progress
        self._results: list[Result] = []
        self._suite: Suite | None = None
        self._fault: Exception | None = None
        self.is_ended = False

    def start(self, clock: Clock, link: Link[CanFrame], on_end: OnEnd) -> None:
        self._suite = Suite(Bench(Line(clock, link), self._eds, self._options), self._cases, self._take)
        self._clock, self._quiet_since_ns = clock, clock.now_ns()
        if self._on_progress is not None:
            self._look_again()
        self._suite.bench.line.play(self._suite.steps(), on_end)

    def _look_again(self) -> None:
        self._clock.call_at(self._quiet_since_ns + QUIET_NS, self._tell)

    def _tell(self) -> None:
        if self.is_ended or self._on_progress is None or self._suite is None:
            return
        now_ns = self._clock.now_ns()
        if now_ns >= self._quiet_since_ns + QUIET_NS:
            self._on_progress(self._suite.doing())
            self._quiet_since_ns = now_ns
        self._look_again()

    def end(self, fault: Exception | None) -> None:
        self.is_ended, self._fault = True, fault

    def report(self, bus: str, date: str) -> Report:
        if self._fault is not None:
            raise self._fault
        notes = [] if self._suite is None else self._suite.notes
        eds = self._eds
        return Report(eds.node_id, eds.path.name, bus, date, version("fieldrig"), self._results, notes)

    def _take(self, result: Result) -> None:
        self._results.append(result)
        self._quiet_since_ns = self._clock.now_ns()
        if self._on_result is not None:
            self._on_result(result)


def _fits(case: Case, pattern: str) -> bool:
    names = (case.number, case.name, case.family, f"{case.number} {case.name}")
    return any(fnmatchcase(name.casefold(), pattern) for name in names)
