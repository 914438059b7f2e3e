"""The search finds bugs that were planted in a small program, makes them small, and says when there is nothing."""

import json
import math
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from lamp_search import HISTORY, PLAN, RACE, SHORT, TWO_BUGS, planted, searched
from typer.testing import CliRunner, Result

from fieldrig.clock import MS, S
from fieldrig.errors import ConfigError, RigError
from fieldrig.virtual.branch import Branch
from fieldrig_devices.scenarios.act import Act, Schedule
from fieldrig_devices.scenarios.command import app as scenario_app
from fieldrig_devices.search.causes import Causes, NotRepeatedError
from fieldrig_devices.search.command import app
from fieldrig_devices.search.corpus import Corpus, Finding
from fieldrig_devices.search.crew import Bench, LocalCrew
from fieldrig_devices.search.minimal import minimal
from fieldrig_devices.search.piece import Piece, Run, acts_of, acts_text
from fieldrig_devices.search.plan import load_plan
from fieldrig_devices.search.search import Limits, Search
from fieldrig_devices.search.strategy import WHOLE, Shard

pytestmark = [pytest.mark.lean, pytest.mark.long]


class Forgetful:
    """A crew that plays the last piece first, and keeps no branch."""

    def __init__(self, bench: Bench) -> None:
        self._bench, self._open = bench, list[Piece]()
        self._ended: dict[str, Run] = {}

    def start(self, piece: Piece) -> None:
        self._open.append(piece)

    def next(self) -> Run:
        piece = self._open.pop(0)
        for other in reversed((piece, *self._open)):
            if repr(other) not in self._ended:
                self._ended[repr(other)] = self._bench.play(other)
                self._bench.drop(self._ended[repr(other)])
        return self._ended.pop(repr(piece))

    def drop(self, run: Run) -> None:
        self._bench.drop(run)


def acts_at(findings: Any) -> list[list[tuple[float, str]]]:
    return [[(act.at_ns / MS, str(act)) for act in one.acts] for one in findings]


def test_a_race_is_found_by_the_sweep_and_made_round(tmp_path: Path) -> None:
    corpus, told = searched(planted(tmp_path, RACE, SHORT), "sweep")
    [[(at_ms, act)], *_] = acts_at(corpus.findings())
    assert act == "wires/switch.on = false"
    assert 250 < at_ms < 280
    assert "(100 %)" in told[0]


def test_a_bug_with_a_history_needs_branches_that_go_on(tmp_path: Path) -> None:
    corpus, told = searched(planted(tmp_path, HISTORY), "archive", most=60)
    assert len(corpus.findings()[0].acts) <= 3
    assert "states" in told[0]


def test_a_search_may_end_at_its_first_finding(tmp_path: Path) -> None:
    corpus, _ = searched(planted(tmp_path, HISTORY), "archive", most=60, is_first=True)
    assert len(corpus.findings()) == 1
    *before, (*_, wrong) = corpus.runs()
    assert wrong
    assert not any(violations for *_, violations in before)


def test_processor_time_ends_a_search(tmp_path: Path) -> None:
    with Bench(load_plan(planted(tmp_path, ""))) as bench, LocalCrew(bench, 1) as crew:
        search = Search(bench.plan, bench, crew, Corpus(None), 1)
        search.go(["swarm"], Limits(math.inf, 2, cpu_s=0.0), lambda _: None)
        assert search.runs == 0
        before_s = search.cpu_s
        search.go(["swarm"], Limits(math.inf, 2, cpu_s=math.inf), lambda _: None)
        assert search.runs == 2
        assert search.cpu_s > before_s > 0.0


def test_a_bug_behind_the_end_of_the_scenario_is_repeated(tmp_path: Path) -> None:
    bug = "hidden(IN := presses > 1, PT := T#3s); IF hidden.Q THEN lamp := TRUE; END_IF"
    plan = planted(tmp_path, bug)
    program = tmp_path / "lamp.st"
    program.write_text(program.read_text().replace("  hold : TON;", "  hold, hidden : TON;"))
    corpus, _ = searched(plan, "archive", most=30)
    [finding, *_] = corpus.findings()
    assert finding.at_ns > 3 * S
    assert finding.length_ns > 3 * S


@pytest.mark.parametrize("strategy", ["sweep", "archive", "swarm"])
def test_a_program_without_a_bug_is_clean(tmp_path: Path, strategy: str) -> None:
    corpus, _ = searched(planted(tmp_path, ""), strategy, most=16)
    assert corpus.findings() == []
    assert len(list(corpus.runs())) > 0


def test_a_search_says_in_the_meantime_how_far_it_is(tmp_path: Path) -> None:
    said = list[str]()
    plan = load_plan(planted(tmp_path, HISTORY))
    with Bench(plan) as bench, LocalCrew(bench, 2) as crew:
        search = Search(plan, bench, crew, Corpus(tmp_path / "c.sqlite"), 3)
        search.go(["swarm"], Limits(math.inf, 4), lambda line: None, said.append, news_s=0)
    assert said[0].startswith("after 0 s: 0 runs, 0 findings; swarm: ")
    assert re.match(r"after \d+ s: 4 runs, \d findings?; swarm: ", said[-1])


def test_the_same_seed_makes_the_same_runs(tmp_path: Path) -> None:
    plan = planted(tmp_path, HISTORY)
    runs = [sorted(searched(plan, "swarm", most=8, seed=seed)[0].runs()) for seed in (3, 3, 4)]
    assert runs[0] == runs[1] != runs[2]


EVERYTHING = """\
rig: rig.yaml
after: 500ms
for: 600ms
steps: [{at: 100ms, set: {wires/switch.on: true}}, {at: 400ms, set: {wires/switch.on: false}}]
recover: [{at: 10ms, restart: terminal}]
properties:
  the lamp goes out: {never: wires/lamp.on and not wires/switch.on, longer: 50ms}
  it comes back: {eventually: not wires/lamp.on, within: 100ms}
vary:
- {faults: {where: wires, kinds: [stuck], durations: [30ms, 500ms]}}
- {press: {wires/switch.on: [true, false]}, hold: [20ms, 50ms]}
- {restart: terminal}
worlds: {seed: [2]}
"""


@pytest.mark.parametrize("strategy", ["archive", "swarm"])
def test_the_outcome_does_not_depend_on_who_plays_what(tmp_path: Path, strategy: str) -> None:
    """One worker, several, and one without branches, which plays everything from the begin and the last piece first."""
    plan = planted(tmp_path, HISTORY.replace(">= 3", ">= 2"), EVERYTHING)
    hashes = {searched(plan, strategy, most=12, workers=workers)[0].hash() for workers in (1, 3)}
    corpus = Corpus(None)
    with Bench(load_plan(plan)) as bench:
        crew = Forgetful(bench)
        Search(bench.plan, bench, crew, corpus, 1).go([strategy], Limits(600.0, 12), lambda _: None)
    assert hashes == {corpus.hash()}
    assert len({run.world for run, *_ in corpus.all_runs()}) == 2
    assert corpus.findings()


@pytest.mark.parametrize(("strategy", "whole", "half"), [("sweep", 10_000, 10_000), ("swarm", 8, 4)])
def test_two_machines_do_together_what_one_does(tmp_path: Path, strategy: str, whole: int, half: int) -> None:
    head, tail = SHORT[: SHORT.index("- {at: 600ms")], SHORT[SHORT.index("properties") :]
    plan = planted(tmp_path, "", head.replace("for: 800ms", "for: 130ms") + tail)

    def acts(most: int, shard: Shard) -> list[Schedule]:
        corpus, _ = searched(plan, strategy, most=most, shard=shard)
        return sorted(acts for acts, *_ in corpus.runs())

    halves = [*acts(half, Shard(0, 2)), *acts(half, Shard(1, 2))]
    assert sorted(halves) == acts(whole, WHOLE)


def test_a_scenario_that_does_not_hold_by_itself_ends_the_search(tmp_path: Path) -> None:
    with pytest.raises(RigError, match="the lamp goes out does not hold without any action besides: at 0"):
        searched(planted(tmp_path, "IF presses > 0 THEN lamp := TRUE; END_IF"), "sweep")


@pytest.mark.parametrize(
    ("vary", "what"),
    [
        ("vary: []", "vary"),
        ("vary: [{set: {a/b: {from: 3, to: 1}}}]", "it is empty"),
        ("vary: [{faults: {where: io, whne: x}}]", "whne"),
        ("vary: [{faults: io, restart: io}]", "it has restart and faults"),
        ("worlds: {seed: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17]}", "at most 16"),
        ("vary: [{at: 5s, set: {a/b: 1}}]", "at"),
    ],
)
def test_a_wrong_plan_is_refused(tmp_path: Path, vary: str, what: str) -> None:
    plan = planted(tmp_path, "", PLAN[: PLAN.index("vary:")] + vary + "\n")
    with pytest.raises(ConfigError, match=what):
        load_plan(plan)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, [*map(str, arguments)])


def test_findings_repeat_as_scenarios_and_as_tests(tmp_path: Path) -> None:
    plan, corpus, found = planted(tmp_path, HISTORY, PLAN), tmp_path / "c.sqlite", tmp_path / "found"
    done = run("run", plan, "--strategy", "swarm", "--most", "8", "--corpus", corpus, "--findings", found)
    assert done.exit_code == 1, done.output
    assert "1. the lamp goes out: at " in done.stdout
    again = CliRunner().invoke(scenario_app, ["run", str(found / "finding-1.yaml")])
    assert again.exit_code == 1, again.output
    assert (found / "finding-1.svg").is_file()
    tested = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_findings.py"],
        cwd=found,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "failed" in tested.stdout.splitlines()[-1], tested.stdout
    assert "the lamp goes out" in tested.stdout
    assert json.loads(run("show", corpus, "--json").stdout)[0]["property"] == "the lamp goes out"


def test_a_fixed_program_is_better_and_a_broken_one_worse(tmp_path: Path) -> None:
    plan, corpus = planted(tmp_path, RACE), tmp_path / "c.sqlite"
    run("run", plan, "--strategy", "swarm", "--most", "8", "--corpus", corpus)
    assert run("compare", plan, corpus).stdout.endswith("0 worse, 0 better\n")
    planted(tmp_path, "IF presses > 1 THEN lamp := TRUE; END_IF")
    worse = run("compare", plan, corpus)
    assert worse.exit_code == 1
    assert "the lamp goes out no longer holds: " in worse.stdout


def test_a_run_that_ended_before_says_nothing_of_what_comes_later(tmp_path: Path) -> None:
    plan, corpus = planted(tmp_path, "IF presses > 1 THEN lamp := TRUE; END_IF"), tmp_path / "c.sqlite"
    later = "  it is pressed at most once: {never: terminal/presses > 1, longer: 200ms}\n"
    first = "  it is pressed: {never: terminal/presses > 1}\n"
    text = plan.read_text()
    plan.write_text(text.replace("vary:", f"{later}{first}vary:"))
    run("run", plan, "--strategy", "swarm", "--most", "8", "--corpus", corpus)
    assert run("compare", plan, corpus).stdout.endswith("0 worse, 0 better\n")
    plan.write_text(text.replace("vary:", f"{later}vary:"))  # the property with which all runs ended is no more
    assert run("compare", plan, corpus).stdout.endswith("0 worse, 0 better\n")


def test_corpora_of_several_machines_are_merged(tmp_path: Path) -> None:
    first, second = (Corpus(tmp_path / name) for name in ("a.sqlite", "b.sqlite"))
    acts = (Act(5 * MS, "fault", "io", {"what": "power_off", "duration_ms": 5}), Act(1 * S, "set", "a/b", True))
    first.add(Run(acts, (), 0), "swarm")
    for corpus in (first, second):
        corpus.add(Run((), (), 0), "sweep")
        corpus.add(Run((), (), 0, world=("seed=3",)), "sweep")
        corpus.note(Finding(0, "p", acts, acts, 5 * S, 7, "wrong"))
    assert "3 runs, 1 finding" in run("merge", tmp_path / "b.sqlite", tmp_path / "a.sqlite").stdout
    assert acts_of(acts_text(acts)) == acts
    (tmp_path / "no.sqlite").write_text("this is no database, but a text that is long enough to be taken for one" * 9)
    assert run("show", tmp_path / "no.sqlite").exit_code != 0
    assert run("merge", tmp_path / "new.sqlite", tmp_path / "missing.sqlite").exit_code != 0
    assert not (tmp_path / "new.sqlite").exists()


def test_what_is_found_is_early_before_it_is_round() -> None:
    acts = (Act(1200 * MS, "restart", "io"),)
    assert minimal(acts, lambda some: any(act.at_ns >= 110 * MS for act in some)) == (Act(200 * MS, "restart", "io"),)


def test_what_is_round_already_does_not_become_later() -> None:
    acts = (Act(100 * MS, "restart", "io"),)
    assert minimal(acts, lambda some: any(act.at_ns >= 100 * MS for act in some)) == acts


def test_what_is_found_is_made_few_round_and_short() -> None:
    def fails(acts: Schedule) -> bool:
        return any(act.verb == "fault" and 900 * MS <= act.at_ns <= 1100 * MS for act in acts)

    fault = Act(1_037_000_001, "fault", "can0", {"what": "drop", "duration_ms": "300"})
    acts = (Act(3 * MS, "restart", "io"), fault, Act(2 * S, "press", "a/b", True, 80 * MS))
    assert minimal(acts, fails) == (Act(1 * S, "fault", "can0", {"what": "drop", "duration_ms": "1"}),)


def run_of(bench: Bench, *acts: Act) -> Run:
    played = bench.play(Piece(acts, 0, 2 * S))
    assert played.violations
    return played


def test_one_finding_of_each_cause(tmp_path: Path) -> None:
    """Two mistakes behind one property are both found, each once, however often it fails."""
    corpus = Corpus(None)
    with Bench(load_plan(planted(tmp_path, TWO_BUGS))) as bench:
        causes = Causes(bench, corpus)
        for at_ms in (270, 274, 278):
            causes.take(run_of(bench, Act(at_ms * MS, "set", "wires/switch.on", False)))
        again = [Act(at_ms * MS, "press", "wires/switch.on", True, 50 * MS) for at_ms in (1110, 1290, 1450)]
        for act in again:
            causes.take(run_of(bench, act))
        causes.take(run_of(bench, *again))
    found = corpus.findings()
    assert sorted(one.acts[0].verb for one in found) == ["press", "set"]
    assert len({one.cause for one in found}) == 2
    assert all("in the 50 ms before:" in one.reason for one in found)


def test_a_finding_is_made_small_without_a_run_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with Bench(load_plan(planted(tmp_path, HISTORY))) as bench:
        causes, play, played = Causes(bench, Corpus(None)), bench.play, list[Piece]()
        many = [Act(at_ms * MS, "press", "wires/switch.on", True, 50 * MS) for at_ms in range(800, 1800, 100)]
        failing = run_of(bench, *many)
        monkeypatch.setattr(bench, "play", lambda piece: played.append(piece) or play(piece))  # type: ignore[func-returns-value]
        assert len(causes.small(failing.violations[0], failing).acts) == 2
    assert len({(acts_text(piece.acts), piece.until_ns) for piece in played}) == len(played)
    assert not any(piece.acts == () for piece in played)


@pytest.mark.parametrize("forgetful", ["play", "told"])
def test_a_run_that_does_not_repeat_is_counted_and_no_finding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, forgetful: str
) -> None:
    """The search goes on, and says so, such as with a master that depends on chance."""
    corpus = Corpus(None)
    with Bench(load_plan(planted(tmp_path, HISTORY))) as bench:
        causes, method = Causes(bench, corpus), getattr(bench, forgetful)
        presses = [Act(at_ms * MS, "press", "wires/switch.on", True, 50 * MS) for at_ms in (800, 900)]
        failing = run_of(bench, *presses)
        monkeypatch.setattr(bench, forgetful, lambda piece: method(piece)._replace(violations=()))
        causes.take(failing)
        assert causes.not_repeated == {failing.violations[0].property: 1}
        with pytest.raises(NotRepeatedError, match="did not break it again"):
            causes.small(failing.violations[0], failing)
    assert corpus.findings() == []


COMES_BACK = """\
properties:
  it comes back: {eventually: not terminal/stuck_lamp, within: 300ms}
"""


@pytest.mark.parametrize(
    ("recover", "is_found"), [("", True), ("recover: [{at: 50ms, set: {terminal/reset: true}}]", False)]
)
def test_whether_the_machine_comes_back_by_what_its_operator_may_do(
    tmp_path: Path, recover: str, is_found: bool
) -> None:
    bug = "IF presses > 1 THEN stuck_lamp := TRUE; END_IF IF reset THEN stuck_lamp := FALSE; presses := 0; END_IF"
    plan = PLAN[: PLAN.index("properties")].replace("for: 2s", "for: 800ms") + COMES_BACK + PLAN[PLAN.index("vary") :]
    file = planted(tmp_path, bug, f"{recover}\n{plan}")
    program = tmp_path / "lamp.st"
    program.write_text(program.read_text().replace("presses : INT;", "presses : INT; stuck_lamp, reset : BOOL;"))
    for strategy in ("archive", "swarm"):
        corpus, _ = searched(file, strategy, most=6)
        assert bool(corpus.findings()) is is_found, strategy


@pytest.mark.parametrize(
    ("strategy", "ends_with"), [("archive", "0 worse, 0 better\n"), ("sweep", "1 worse, 0 better\n")]
)
def test_a_piece_that_others_go_on_from_is_compared_up_to_its_end(
    tmp_path: Path, strategy: str, ends_with: str
) -> None:
    """Played alone it goes on until all faults are healed, which the search has not judged."""
    plan, file = planted(tmp_path, ""), tmp_path / "c.sqlite"
    wrong = "the switch is on again: {never: not wires/switch.on, longer: 900ms}"
    plan.write_text(plan.read_text().replace("properties:\n", f"properties:\n  {wrong}\n"))
    acts = (Act(700 * MS, "fault", "terminal", {"what": "power_off", "duration_ms": 1000}),)
    Corpus(file).add(Run(acts, (), 750 * MS), strategy)
    assert run("compare", plan, file).stdout.endswith(ends_with)


def test_a_piece_whose_process_is_killed_is_played_again(tmp_path: Path) -> None:
    """A killed branch to go on from, a parked one or one along the nominal run, is made again."""
    plan = load_plan(planted(tmp_path, HISTORY))
    press = Act(700 * MS, "press", "wires/switch.on", True, 50 * MS)
    first = Piece((press,), 0, 1 * S, is_whole=False)
    onward = Piece((press, press._replace(at_ns=1200 * MS)), 1 * S, 2 * S)
    late = Piece((press._replace(at_ns=900 * MS),), 0, 2 * S)
    with Bench(plan) as bench:
        expected = [bench.play(piece) for piece in (first, onward, late)]
    with Bench(plan) as bench, LocalCrew(bench, 1) as crew:
        crew.start(first)
        _kill(next(iter(crew._running)))
        played = [crew.next()]
        _kill(next(iter(bench._parked.values())))
        crew.start(onward)
        played.append(crew.next())
        trunk = bench._standing(()).trunk
        _kill(trunk.before(900 * MS))
        crew.start(late)
        played.append(crew.next())
    assert [one._replace(cpu_s=0) for one in played] == [one._replace(cpu_s=0) for one in expected]
    assert played[1].violations


def _kill(branch: Branch) -> None:
    """End its process; what it has answered before is lost as well."""
    os.kill(branch.pid, signal.SIGKILL)
    while branch._pipe.poll(None):
        try:
            branch._pipe.recv_bytes()
        except (EOFError, OSError):
            return
