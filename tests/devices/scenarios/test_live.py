"""Scenarios in real time: to a rig that is started for them, and to one that runs already."""

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from fieldrig.clock import MS, S
from fieldrig.errors import ConfigError, UsageError
from fieldrig.real import bus_inbox
from fieldrig.real.live_rig import LiveRig
from fieldrig_devices.scenarios import Scenario
from fieldrig_devices.scenarios.command import app
from fieldrig_devices.scenarios.report import SEES_ALL, failures
from fieldrig_devices.scenarios.running import played

pytestmark = pytest.mark.system

RIG = """
time: real
control: CONTROL
buses:
  can0: {kind: can.hub, bitrate: 500000}
  wires: {kind: wires.hub}
devices:
  tank:
    kind: plant.tank
    area_m2: 1
    height_m: 2
    outlet_area_m2: 0
    pump_flow_m3_per_s: 0.01
    initial_level_m: 0.5
    links: {wires: wires}
  io: {kind: canopen.node, node_id: 5, eds: EDS, links: {can: can0}}
"""
SCENARIO = """
rig: rig.yaml
after: 500ms
steps:
  - {at: 100ms, set: {tank/level: 1.0}}
  - {at: 300ms, send: {can0: '000#0105'}}
  - {when: io/nmt.state == operational, fault: io power_off duration_ms=300}
  - {when: 'message(can0, node=io, service=boot-up)', set: {tank/level: 1.5}}
  - {when: tank/level == 7, clear: io}
for: 2500ms
properties:
  never low: {never: tank/level < 0.4}
  starts: {expect: io/nmt.state == operational, within: 1s, after: 'message(can0, id=0)'}
  boots once: {always: 'count(can0, node=io, service=boot-up) <= 1'}
  low: {never: tank/level == 1.0}
  back: {eventually: io/nmt.state == pre_operational, within: 2s}
  silent: {always: 'since(can0, node=io) < 0.2', after: tank/level == 1.0}
"""
EDS = Path(__file__).parents[3] / "configs" / "eds"


def written(folder: Path, scenario: str = SCENARIO, control: str = "tcp/127.0.0.1:7999") -> Path:
    eds = next(iter(sorted(EDS.glob("io32*.eds"))))
    (folder / "rig.yaml").write_text(RIG.replace("CONTROL", control).replace("EDS", str(eds)))
    (folder / "it.yaml").write_text(scenario)
    return folder / "it.yaml"


def judged(file: Path, *options: str) -> dict[str, Any]:
    done = CliRunner().invoke(app, ["run", str(file), "--json", *options])
    assert done.stdout, done.output
    [found] = json.loads(done.stdout)
    result: dict[str, Any] = found
    return result


def test_a_scenario_starts_its_rig_and_judges_what_its_processes_record(tmp_path: Path) -> None:
    found = judged(written(tmp_path), "--real")
    broken = {one["property"]: one for one in found["violations"]}
    assert set(broken) == {"low", "silent"}
    assert broken["low"]["at_s"] >= 0.1
    assert broken["low"]["values"] == {"tank/level": 1.0}
    assert broken["silent"]["at_s"] > 0.2
    steps = [one["step"] for one in found["steps"]]
    assert steps[:3] == ["tank/level = 1.0", "send can0 000#0105", "fault io power_off duration_ms=300"]
    assert "tank/level = 1.5" in steps
    assert [one["why"] for one in found["unreached"]] == ["`tank/level == 7` was not true"]
    assert found["notes"][0].startswith("real time: actions were done up to")
    assert all(0 <= one["late_s"] < 60 for one in found["steps"])
    assert found["hash"] == ""


EVERY_STEP = """
rig: rig.yaml
after: 500ms
steps:
  - {at: 50ms, fault: 'io emergency code=0x8130'}
  - {when: diagnosis(io 0x8130), press: {tank/level: 1.5}, hold: 100ms}
  - {when: tank/level == 1.5, nth: 1, at: 10ms, clear: io}
  - {when: tank/level == 1.5, at: 50ms, set: {wires/pump.run: true}}
  - {when: wires/pump.run, at: 100ms, restart: io}
for: 4s
properties:
  code: {never: diagnosis(io 0x8140)}
"""
"""All steps but those of SCENARIO, and a diagnosis in a property as in a milestone."""


@pytest.mark.parametrize("options", [["--real"], []])
def test_every_step_and_a_diagnosis_in_both_times(tmp_path: Path, options: list[str]) -> None:
    found = judged(written(tmp_path, EVERY_STEP), *options)
    assert found["violations"] == []
    assert found["unreached"] == []
    steps = [one["step"] for one in found["steps"]]
    assert {"tank/level = 1.5 for 100 ms", "clear io", "wires/pump.run = true", "restart io"} <= set(steps)


def test_the_same_file_in_virtual_time(tmp_path: Path) -> None:
    found = judged(written(tmp_path))
    assert [one["property"] for one in found["violations"]] == ["low", "silent"]
    assert found["notes"] == []


def test_a_scenario_is_played_to_the_rig_that_runs_and_leaves_it_running(tmp_path: Path) -> None:
    file = written(tmp_path)
    with LiveRig(tmp_path / "rig.yaml") as rig:
        text = "steps: [{at: 0s, set: {tank/level: 1.25, wires/pump.run: true}}]\nfor: 500ms\n"
        rules = "{set: {expect: tank/level >= 1.25, within: 400ms}, pumps: {expect: wires/pump.run, within: 400ms}}"
        file.write_text(f"rig: rig.yaml\n{text}properties: {rules}\n")
        outcome = played(file, ("time=real", f"control={rig.endpoint}"))
        assert outcome.is_good, outcome.played
        level = rig.get("tank/level")
        assert isinstance(level, float)
        assert level >= 1.25
        here = Scenario(length=300 * MS)
        here.set("tank/level", 0.75, when="tank/level > 1.2")
        here.expect("tank/level == 0.75", within=3 * S)
        here.never("tank/level > 9")
        assert here.run(rig).tracks["tank/level"][-1][1] == rig.get("tank/level")
        (tmp_path / "other.yaml").write_text((tmp_path / "rig.yaml").read_text())
        file.write_text(file.read_text().replace("rig.yaml", "other.yaml"))
        with pytest.raises(UsageError, match="is rig in real time, not other"):
            played(file, ("time=real", f"control={rig.endpoint}"))


def test_a_scenario_that_missed_messages_does_not_pass(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bus_inbox, "MOST_MESSAGES", 0)
    text = "rig: rig.yaml\nsteps: [{at: 0s, send: {can0: '000#0105'}}]\nfor: 300ms\n"
    file = written(tmp_path, f"{text}properties: {{quiet: {{never: 'count(can0) > 99'}}}}\n")
    outcome = played(file, ("time=real",))
    assert outcome.violations == ()
    assert outcome.played.missed >= 1
    assert not outcome.is_good
    [(name, reason)] = failures(outcome)
    assert name == SEES_ALL
    assert reason.startswith(f"the scenario missed {outcome.played.missed} message")


def test_a_step_that_comes_later_than_it_may_fails_the_scenario(tmp_path: Path) -> None:
    text = "rig: rig.yaml\nlateness: 0ms\nsteps: [{at: 10ms, set: {tank/level: 1.0}}]\nfor: 100ms\n"
    file = written(tmp_path, f"{text}properties: {{low: {{never: tank/level > 1.5}}}}\n")
    assert played(file).is_good, "nothing is late in virtual time"
    outcome = played(file, ("time=real",))
    assert outcome.violations == ()
    [late_ns] = outcome.played.lateness
    assert failures(outcome) == [("step: tank/level = 1.0", f"it was {late_ns / MS:.0f} ms late, and may be 0 ms")]


def test_mistakes_are_told_before_a_rig_starts(tmp_path: Path) -> None:
    file = written(tmp_path, SCENARIO.replace("tank/level < 0.4", "tank/levle < 0.4"))
    with pytest.raises(ConfigError, match="did you mean level") as caught:
        played(file, ("time=real",))
    assert [one.line for one in caught.value.mistakes] == [12]
