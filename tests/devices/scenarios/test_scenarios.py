"""Scenario files: what they may say, how they are played, and what is reported of them."""

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import pytest
from typer.testing import CliRunner, Result

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import load
from fieldrig.errors import ConfigError, RigError, UsageError
from fieldrig.virtual.rig import Rig
from fieldrig_devices.scenarios.command import app
from fieldrig_devices.scenarios.play import Played, play
from fieldrig_devices.scenarios.scenario_file import Scenario, load_scenario

CONFIGS = Path(__file__).parents[3] / "configs"
HEAD = f"rig: {CONFIGS / 'lab.yaml'}\n"
LEVEL = "properties: {dry: {always: tank/level > 0.1}}\n"


def scenario(folder: Path, text: str) -> Path:
    file = folder / "it.yaml"
    file.write_text(HEAD + text)
    return file


def refused(folder: Path, text: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        load_scenario(scenario(folder, text))
    return [f"{one.line}: {one.key}: {one.what}" for one in caught.value.mistakes]


def played(folder: Path, text: str, **options: Any) -> Played:
    given = load_scenario(scenario(folder, text))
    with Rig(load(given.rig, ("time=virtual",))) as rig:
        rig.run_until(given.after_ns)
        return play(rig, given.schedule, given.properties, given.length_ns, **options)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["run", *map(str, arguments)])


@pytest.mark.parametrize(
    ("text", "mistake"),
    [
        ("properties: {}\n", "2: properties: "),
        ("properties: {a: {}}\n", "2: properties.a: it says nothing"),
        ("properties: {a: {always: x/y, never: x/y}}\n", "2: properties.a: it has always and never"),
        ("properties: {a: {expect: x/y}}\n", "2: properties.a.within: expect needs a time"),
        ("properties: {a: {stays: x/y}}\n", "2: properties.a.until: stays needs an end"),
        ("properties: {a: {never: x/y, within: 1s}}\n", "2: properties.a.within: never takes no time"),
        ("properties: {a: {never: level > 3}}\n", "2: properties.a.never: got 'level'"),
        ("properties: {a: {never: 3}}\n", "2: properties.a.never: "),
        (f"steps: [{{at: 5, clear: io}}]\n{LEVEL}", "2: steps[0].at: expected a time with a unit"),
        (f"steps: [{{at: 5s}}]\n{LEVEL}", "2: steps[0]: it does nothing"),
        (f"steps: [{{at: 5s, fault: io}}]\n{LEVEL}", "2: steps[0].fault: expected a bus or device with a fault"),
        (f"steps:\n- {{at: 5s, clear: io}}\n- {{at: 4s, clear: io}}\n{LEVEL}", "4: steps[1].at: it is before"),
        (f"steps: [{{at: 5s, clear: io}}]\nfor: 4s\n{LEVEL}", "3: for: the last step is later"),
        (f"stepps: []\n{LEVEL}", "2: stepps: "),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(tmp_path: Path, text: str, mistake: str) -> None:
    found = refused(tmp_path, text)
    assert any(one.startswith(mistake) for one in found), found


def test_the_length_is_enough_for_the_last_step_and_the_longest_wait(tmp_path: Path) -> None:
    steps = "steps: [{at: 5s, press: {drive/run: true}, hold: 300ms}]\n"
    text = f"{steps}properties: {{a: {{eventually: drive/run, within: 4s}}}}\n"
    assert load_scenario(scenario(tmp_path, text)).length_ns == 5 * S + 300 * MS + 4 * S + 1 * S


def test_actions_come_at_their_instants(tmp_path: Path) -> None:
    text = """steps:
- {at: 100ms, set: {drive/speed_set: 50}}
- {at: 250ms, press: {drive/run: true}, hold: 400ms}
- {at: 300ms, restart: io}
properties: {runs: {never: drive/run}}
for: 2s
"""
    found = played(tmp_path, text)
    assert [found.at_ns for found in found.violations] == [250 * MS]
    assert found.tracks["drive/run"] == ((0, False), (250 * MS, True), (650 * MS, False))
    assert found.tracks["drive/speed_set"][-1] == (100 * MS, 50)
    assert found.length_ns == 2 * S


def test_a_recovery_waits_for_the_end_of_the_last_fault(tmp_path: Path) -> None:
    text = """steps:
- {at: 100ms, fault: can0 drop duration_ms=700}
- {at: 200ms, fault: io power_off duration_ms=300}
properties:
  back: {eventually: io/nmt.state == 'pre_operational', within: 500ms}
  early: {eventually: io/nmt.state == 'operational', within: 500ms}
"""
    found = played(tmp_path, text)
    assert [(one.property, one.at_ns) for one in found.violations] == [("early", 1300 * MS)]


def test_the_same_scenario_gives_the_same_bytes_in_a_branch(tmp_path: Path) -> None:
    given = load_scenario(
        scenario(
            tmp_path,
            "steps: [{at: 100ms, fault: can0 corrupt probability=0.3 duration_ms=500}]\n"
            "properties: {dry: {never: tank/level < 0.1}}\nfor: 2s\n",
        )
    )
    with Rig(load(given.rig, ("time=virtual",))) as rig:
        rig.trace_hash()
        rig.run_until(1 * S)
        with rig.branch() as branch:
            there = branch.call(_play_all, given)
        here = play(rig, given.schedule, given.properties, given.length_ns)
    assert there == (here.hash, here.violations)


def _play_all(rig: Rig, given: Scenario) -> tuple[str, object]:
    found = play(rig, given.schedule, given.properties, given.length_ns)
    return found.hash, found.violations


def test_it_may_end_at_the_first_violation(tmp_path: Path) -> None:
    text = "steps: [{at: 100ms, set: {drive/run: true}}]\nproperties: {off: {never: drive/run}}\nfor: 60s\n"
    assert played(tmp_path, text, stops_early=True).length_ns == 100 * MS


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("properties: {a: {never: tank/levle > 3}}\n", "levle"),
        ("properties: {a: {never: tnak/level > 3}}\n", "tnak"),
        ("properties: {a: {never: io/nmt.state > 3}}\n", "cannot be judged"),
        (f"steps: [{{at: 0s, fault: can0 dorp}}]\n{LEVEL}", "dorp"),
        (f"steps: [{{at: 0s, set: {{drive/run: 7}}}}]\n{LEVEL}", "run"),
    ],
)
def test_what_the_rig_does_not_have_is_refused(tmp_path: Path, text: str, what: str) -> None:
    with pytest.raises(RigError, match=what):
        played(tmp_path, text)


def test_the_command_tells_reasons_and_writes_reports(tmp_path: Path) -> None:
    steps = "steps: [{at: 100ms, set: {drive/run: true}}]\n"
    text = f"{steps}properties: {{<off>: {{never: drive/run}}, wet: {{never: tank/level < 0}}}}\n"
    file = scenario(tmp_path, text)
    trace = tmp_path / "it.log"
    done = run(file, "--junit", tmp_path / "j.xml", "--pictures", tmp_path / "pictures", "--trace", trace)
    assert done.exit_code == 1
    assert "FAILED  <off>\n          at 0.1 s: `drive/run` was true\n          drive/run = true\n" in done.stdout
    assert "ok      wet" in done.stdout
    [suite] = Xml.parse(tmp_path / "j.xml").getroot()
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    failed, passed = suite
    assert (failed.get("name"), failed.get("file"), failed.get("line")) == ("<off>", str(file), "3")
    assert (passed.get("line"), len(passed)) == ("3", 0)
    whole, around = (Xml.parse(tmp_path / "pictures" / name).getroot() for name in ("it.svg", "it-1.svg"))
    shown, near = " ".join(whole.itertext()), " ".join(around.itertext())
    assert "tank/level" in shown
    assert "tank/level" not in near
    assert "0.1 s: <off>: `drive/run` was true" in near
    assert "drive/run = true" in near
    assert [line.split()[2] for line in trace.read_text().splitlines()][:1] == ["705#00"]
    [told] = json.loads(run(file, "--json").stdout)
    assert told["violations"][0]["at_s"] == 0.1


@pytest.mark.long
@pytest.mark.parametrize("file", sorted((CONFIGS / "scenarios").glob("*.yaml")), ids=lambda file: file.stem)
def test_the_shipped_scenarios_hold(file: Path) -> None:
    done = run(file)
    assert done.exit_code == 0, done.output


def test_the_operator_acts_when_all_faults_are_over(tmp_path: Path) -> None:
    """The pump was switched off by the power cycle of its drive, and only an operator starts it again."""
    text = """steps:
- {at: 100ms, set: {drive/speed_set: 50, drive/run: true}}
- {at: 900ms, fault: drive power_off duration_ms=500}
for: 1s
recover:
- {at: 200ms, set: {drive/speed_set: 50}}
- {at: 300ms, set: {drive/run: true}}
properties:
  pumps: {eventually: tank/inflow > 0.0, within: 50ms}
  pumps faster: {eventually: tank/inflow > 0.0006, within: 2s}
"""
    found = played(tmp_path, text, recovery=load_scenario(scenario(tmp_path, text)).recovery)
    assert [(one.property, one.at_ns) for one in found.violations] == [("pumps faster", 3700 * MS)]


def test_a_fault_at_the_end_leaves_the_machine_its_time_to_come_back(tmp_path: Path) -> None:
    text = """steps: [{at: 900ms, fault: io power_off duration_ms=300}]
for: 1s
properties: {back: {eventually: io/nmt.state == 'pre_operational', within: 500ms}}
"""
    assert played(tmp_path, text).violations == ()


def test_a_folder_without_scenarios_is_refused(tmp_path: Path) -> None:
    wrong = run(tmp_path)
    assert isinstance(wrong.exception, UsageError)
    assert "has no scenario files" in str(wrong.exception)
    scenario(tmp_path, LEVEL)
    assert run(tmp_path).exit_code == 0


def test_a_trace_is_of_one_scenario_in_a_known_format(tmp_path: Path) -> None:
    file = scenario(tmp_path, LEVEL)
    assert run(file, file, "--trace", tmp_path / "it.log").exit_code == 2
    wrong = run(file, "--trace", tmp_path / "it.lgo")
    assert isinstance(wrong.exception, UsageError)
    assert "no format of traces ends in" in str(wrong.exception)
