"""A Python master in virtual time as the program under test: it begins again in each branch, always the same."""

from pathlib import Path

import pytest

from fieldrig.clock import MS
from fieldrig.master_time import program
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.guard import MASTER_WORKS
from fieldrig_devices.scenarios.running import played
from fieldrig_devices.scenarios.with_master import GOES_ON
from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.corpus import Corpus
from fieldrig_devices.search.crew import LocalCrew
from fieldrig_devices.search.findings import write
from fieldrig_devices.search.piece import Piece
from fieldrig_devices.search.plan import load_plan
from fieldrig_devices.search.search import Limits, Search

pytestmark = [pytest.mark.lean, pytest.mark.long]
pytest.importorskip("can")
CONFIGS = Path(__file__).parents[3] / "configs"
MASTER = """\
import time
import can

with can.Bus(interface="fieldrig", channel="can0") as bus:
    print("this is not printed")
    time.sleep(0.1)
    bus.send(can.Message(arbitration_id=0, data=[1, 5], is_extended_id=False))
    while True:
        frame = bus.recv(1.0)
        if frame is not None and frame.arbitration_id == 0x705 and frame.data[0] == 0:
            {booted}
"""
"""It starts node 5, and should start it again when it has booted."""
GOOD = "bus.send(can.Message(arbitration_id=0, data=[1, 5], is_extended_id=False))"
PLAN = f"""\
rig: {CONFIGS / "lab.yaml"}
master: master.py
after: 100ms
for: 1s
properties:
  operational: {{always: io/nmt.state == operational, after: io/nmt.state == operational, longer: 300ms}}
vary: [{{restart: io}}]
"""


def planned(folder: Path, booted: str, plan: str = PLAN) -> Path:
    (folder / "master.py").write_text(MASTER.format(booted=booted))
    (folder / "plan.yaml").write_text(plan)
    return folder / "plan.yaml"


def test_a_master_that_forgets_a_node_is_found_and_each_run_is_the_same(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    plan, corpus = load_plan(planned(tmp_path, "pass")), Corpus(None)
    acts = (Act(300 * MS, "restart", "io"),)
    with Bench(plan) as bench, LocalCrew(bench, 2) as crew:
        ways = [bench.told(Piece(acts, 0, plan.scenario.length_ns)).hash for _ in range(2)]
        assert ways[0] == ways[1]
        Search(plan, bench, crew, corpus, 1).go(["archive"], Limits(600, 6), lambda _: None)
    assert [(one.property, len(one.acts)) for one in corpus.findings()] == [("operational", 1)]
    assert capfd.readouterr().out == ""


def test_the_master_itself_is_clean_in_a_scenario_and_late_with_jitter(tmp_path: Path) -> None:
    def outcome(plan: str) -> str:
        file = planned(tmp_path, GOOD, plan[: plan.index("vary")])
        shown = played(file).played
        assert shown.violations == ()
        return shown.hash

    plans = [
        PLAN,
        PLAN.replace("after: 100ms", "jitter: 20ms\nafter: 100ms"),
        PLAN.replace("after: 100ms", "jitter: 20ms\noverrides: [seed=5]\nafter: 100ms"),
    ]
    assert len({outcome(plan) for plan in plans}) == 3
    assert outcome(plans[1]) == outcome(plans[1])


@pytest.mark.parametrize(
    ("end", "what"),
    [
        ("1 / 0", "ZeroDivisionError: division by zero (master.py:11 in <module>)"),
        ("raise SystemExit(3)", "it ends with the exit code 3"),
    ],
)
def test_a_master_that_fails_is_a_violation_and_the_rest_is_judged_too(tmp_path: Path, end: str, what: str) -> None:
    text = PLAN[: PLAN.index("vary")].replace("for: 1s", "for: 1s\nsteps: [{at: 300ms, restart: io}]")
    found = {one.property: one for one in played(planned(tmp_path, end, text)).played.violations}
    assert list(found) == ["operational", MASTER_WORKS]
    failed = found[MASTER_WORKS]
    assert failed.what == what
    assert 300 * MS < failed.at_ns < found["operational"].at_ns


def test_a_master_may_end_when_it_likes(tmp_path: Path) -> None:
    for end in ("raise SystemExit", "raise SystemExit(0)", "break"):
        text = PLAN[: PLAN.index("vary")].replace("for: 1s", "for: 250ms\nsteps: [{at: 100ms, restart: io}]")
        assert [one.property for one in played(planned(tmp_path, end, text)).played.violations] == [], end


def test_a_search_finds_what_makes_a_master_fail_and_its_finding_repeats_it(tmp_path: Path) -> None:
    plan, corpus = load_plan(planned(tmp_path, "raise OSError(frame)")), Corpus(None)
    with Bench(plan) as bench, LocalCrew(bench, 2) as crew:
        Search(plan, bench, crew, corpus, 1).go(["swarm"], Limits(600, 6), lambda _: None)
    [finding] = [one for one in corpus.findings() if one.property == MASTER_WORKS]
    assert [(act.verb, act.where) for act in finding.acts] == [("restart", "io")]
    [file] = write(plan.scenario, [finding], tmp_path / "found")
    again = played(file).played
    assert MASTER_WORKS in [one.property for one in again.violations]
    assert again.hash_then == finding.hash


def test_a_master_that_computes_without_end_is_a_violation_with_its_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(program, "PATIENCE_S", 0.5)
    file = planned(tmp_path, "pass", PLAN[: PLAN.index("vary")])
    (tmp_path / "master.py").write_text("import time\ntime.sleep(0.2)\nwhile True:\n    pass\n")
    [violation] = played(file).played.violations
    assert (violation.property, violation.at_ns) == (GOES_ON, 200 * MS)
    assert "thread master has run for 0.5 s without waiting" in violation.what
    assert "master.py:" in violation.what


def test_a_master_that_waits_for_nothing_in_the_rig_breaks_a_property_of_its_own(tmp_path: Path) -> None:
    file = planned(tmp_path, "pass", PLAN[: PLAN.index("vary")])
    (tmp_path / "master.py").write_text("import subprocess\nsubprocess.run(['true'])\n")
    [violation] = played(file).played.violations
    assert violation.property == GOES_ON
    assert "process" in violation.what
