"""The search for faults: runs an hour of three shipped rigs, what a search costs, and two workers instead of one."""

import sys
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from report import COMPARED, Report, progress  # noqa: E402  found beside this file

from fieldrig.clock import S  # noqa: E402
from fieldrig.virtual.branch import Branch  # noqa: E402
from fieldrig.virtual.rig import Rig  # noqa: E402
from fieldrig_devices.scenarios.act import Act, Schedule  # noqa: E402
from fieldrig_devices.scenarios.expression import expression_of  # noqa: E402
from fieldrig_devices.scenarios.property import Kind, Property  # noqa: E402
from fieldrig_devices.scenarios.scenario_file import Scenario  # noqa: E402
from fieldrig_devices.search import run as in_branch  # noqa: E402
from fieldrig_devices.search.bench import Bench  # noqa: E402
from fieldrig_devices.search.crew import LocalCrew  # noqa: E402
from fieldrig_devices.search.piece import Piece, Run  # noqa: E402
from fieldrig_devices.search.plan import Plan  # noqa: E402
from fieldrig_devices.search.state_places import Sort  # noqa: E402
from fieldrig_devices.search.vary import VarySettings  # noqa: E402

CONFIGS = HERE.parents[1] / "configs"
LENGTH_NS = 4 * S
"""The length of a run."""
PAIRS = 3
PIECES = 12
"""Runs of each of a pair."""
SCENARIOS: dict[str, tuple[int, Schedule, str, dict[str, str]]] = {
    "feeder": (
        60 * S,
        (Act(S // 10, "set", "feeder/g_bStart", True), Act(2 * S, "set", "feeder/g_bStart", False)),
        "wires/feeder.seal and not feeder/g_bHot",
        {"fault": "stepper trip duration_ms=300"},
    ),
    "conveyor": (
        6 * S,
        (Act(S // 2, "set", "panel/6200:01", 3), Act(3 * S, "set", "panel/6200:01", 1)),
        "max4/g_lState_1 > 100",
        {"fault": "ring break after=belt duration_ms=200"},
    ),
    "pam-machine": (
        4 * S,
        (Act(S // 10, "set", "plc/DIF_Start", 1),),
        "pam/DOW_State > 100",
        {"fault": "belt jam duration_ms=300"},
    ),
}
"""The instant of the begin, what happens, what must never be, and what may happen besides, by rig."""


def plan_of(name: str) -> Plan:
    after_ns, schedule, wrong, vary = SCENARIOS[name]
    rule = Property("it holds", Kind.NEVER, expression_of(wrong))
    scenario = Scenario(CONFIGS / f"{name}.yaml", (), after_ns, LENGTH_NS, schedule, (), (rule,))
    settings = VarySettings.model_validate(vary)
    return Plan(scenario, (settings,), ((),), rule.places, rule.places, frozenset(Sort))


def pieces(bench: Bench) -> Iterator[Piece]:
    """Yield runs with one action each, spread over the scenario, none of which goes on from a branch on the way."""
    [choice] = bench.choices
    for number in range(PIECES):
        yield Piece(tuple(choice.all(number * LENGTH_NS // PIECES)), 0, LENGTH_NS)


def wall_s(bench: Bench, workers: int) -> float:
    with LocalCrew(bench, workers) as crew:
        begin_s = time.perf_counter()
        for piece in pieces(bench):
            crew.start(piece)
        for _ in range(PIECES):
            crew.next()
        return time.perf_counter() - begin_s


def played_s(rig: Rig, piece: Piece) -> float:
    """Return the processor time of a run of the search."""
    begin_s = time.process_time()
    played: Run = in_branch.play_piece(rig, piece)
    assert not played.violations, played
    return time.process_time() - begin_s


def alone_s(rig: Rig, acts: Schedule) -> float:
    """Return the processor time of the same run without any search: no judge, no eye, no hash."""
    begin_ns, begin_s = rig.now_ns, time.process_time()
    for act in sorted(acts, key=lambda act: act.at_ns):
        rig.run_until(begin_ns + act.at_ns)
        if act.verb == "set":
            rig.set(act.where, act.value)  # type: ignore[arg-type]
        else:
            rig.add_fault(act.where, act.value)  # type: ignore[arg-type]
    rig.run_until(begin_ns + LENGTH_NS)
    return time.process_time() - begin_s


def run() -> Report:
    report = Report(
        "The search for faults",
        f"This table shows the runs of {LENGTH_NS // S} virtual seconds, each with one fault, that one core makes in an"
        f" hour, by their processor time; and how much faster {PIECES} runs are with two workers than with one, the"
        f" median of {PAIRS} pairs. A run without a search has the same actions and faults, and nothing is judged.",
        COMPARED,
    )
    for name in SCENARIOS:
        progress(f"search: {name}")
        with Bench(plan_of(name)) as bench, bench.rig.branch() as bare:
            _measure(report, name, bench, bare)
    return report


def _measure(report: Report, name: str, bench: Bench, bare: Branch) -> None:
    searched, without = list[float](), list[float]()
    for piece in list(pieces(bench))[::2]:
        with bench.root.branch() as branch:
            searched.append(branch.call(played_s, piece))
        with bare.branch() as branch:
            without.append(branch.call(alone_s, (*bench.plan.scenario.schedule, *piece.acts)))
    cost_s, bare_s = median(searched), median(without)
    report.add(
        f"{name}: runs an hour and core",
        f"{3600 / cost_s:,.0f}",
        f"without a search, {3600 / bare_s:,.0f}",
        cost_s / bare_s,
    )
    begin_s = time.process_time()
    ratios = [wall_s(bench, 1) / wall_s(bench, 2) for _ in range(PAIRS)]
    own_s = (time.process_time() - begin_s) / (2 * PAIRS * PIECES)
    report.add(
        f"{name}: the search's own time for a run",
        f"{1e3 * own_s:.1f} ms",
        f"the run, {1e3 * cost_s:.0f} ms",
        own_s / cost_s,
    )
    report.add(f"{name}: two workers", f"{median(ratios):.2f} times as fast", "1.9", median(ratios) / 1.9)


if __name__ == "__main__":
    print(run().markdown())
