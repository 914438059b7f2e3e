"""Steps that come at a milestone: the condition of the fault form, for each sort of step."""

from pathlib import Path

import pytest

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import load
from fieldrig.errors import ConfigError
from fieldrig.virtual.rig import Rig
from fieldrig_devices.scenarios.checks import check
from fieldrig_devices.scenarios.play import Played, play
from fieldrig_devices.scenarios.scenario_file import load_scenario

CONFIGS = Path(__file__).parents[3] / "configs"
OFF = "properties: {off: {never: drive/run}}\nfor: 3s\n"


def played(folder: Path, steps: str, rest: str = OFF) -> Played:
    file = folder / "it.yaml"
    file.write_text(f"rig: {CONFIGS / 'lab.yaml'}\nafter: 2s\nsteps:\n{steps}{rest}")
    given = load_scenario(file)
    with Rig(load(given.rig, ("time=virtual",))) as rig:
        rig.run_until(given.after_ns)
        check(rig, given)
        return play(rig, given.schedule, given.properties, given.length_ns)


def instants_ms(found: Played) -> list[tuple[str, float]]:
    return [(str(act), act.at_ns / MS) for act in found.done]


def test_a_step_comes_after_a_message_and_the_time_behind_it(tmp_path: Path) -> None:
    found = played(
        tmp_path,
        "- {when: 'message(can0, node=sensor)', nth: 2, at: 50ms, set: {drive/run: true}}\n"
        "- {when: drive/run, press: {drive/speed_set: 40}, hold: 10ms}\n",
    )
    assert [(one, round(at_ms, 1)) for one, at_ms in instants_ms(found)] == [
        ("drive/run = true", 1050.5),
        ("drive/speed_set = 40 for 10 ms", 1050.5),
        ("drive/speed_set = 0.0", 1060.5),
    ]
    assert [one.at_ns for one in found.violations] == [found.done[0].at_ns]


@pytest.mark.parametrize(
    ("step", "told"),
    [
        ("fault: can0 drop duration_ms=1", "fault can0 drop duration_ms=1"),
        ("clear: io", "clear io"),
        ("restart: io", "restart io"),
        ("send: {can0: '000#0105'}", "send can0 000#0105"),
    ],
)
def test_each_sort_of_step_has_milestones(tmp_path: Path, step: str, told: str) -> None:
    found = played(tmp_path, f"- {{at: 5ms, set: {{drive/speed_set: 7}}}}\n- {{when: drive/speed_set == 7, {step}}}\n")
    assert instants_ms(found)[1] == (told, 5.0)


def test_one_that_is_true_already_comes_at_once(tmp_path: Path) -> None:
    found = played(tmp_path, "- {when: io/nmt.state == pre_operational, clear: io}\n")
    assert instants_ms(found) == [("clear io", 0.0)]


def test_a_level_that_changes_without_an_event_is_a_milestone(tmp_path: Path) -> None:
    steps = "- {at: 0s, set: {drive/speed_set: 80, drive/run: true}}\n- {when: tank/level > 0.5005, clear: io}\n"
    found = played(tmp_path, steps, "properties: {a: {never: tank/level > 0.500501}}\nfor: 3s\n")
    assert not found.unreached
    [violation] = found.violations
    assert 0 <= violation.at_ns - found.done[-1].at_ns < S


def test_a_milestone_that_is_never_reached_is_told(tmp_path: Path) -> None:
    found = played(tmp_path, "- {when: tank/level > 9, clear: io}\n")
    assert [act.milestone for act in found.unreached] == ["tank/level > 9"]


def test_one_that_comes_after_the_end_is_told(tmp_path: Path) -> None:
    found = played(tmp_path, "- {when: 'message(can0 node=sensor)', at: 9s, clear: io}\n")
    assert [(str(act), act.when, act.at_ns // S) for act in found.unreached] == [("clear io", "", 9)]


def test_a_recovery_that_could_not_be_judged_is_told(tmp_path: Path) -> None:
    rules = "properties: {back: {eventually: io/nmt.state == pre_operational, within: 1s}}\nfor: 3s\n"
    found = played(tmp_path, "- {at: 0s, fault: can0 drop}\n", rules)
    assert (found.violations, found.unjudged) == ((), ("back",))
    assert played(tmp_path, "- {at: 0s, fault: can0 drop duration_ms=9}\n", rules).unjudged == ()


@pytest.mark.parametrize(
    ("step", "mistake"),
    [
        ("{clear: io}", "it says nothing of when"),
        ("{at: 1s, nth: 2, clear: io}", "nth counts"),
        ("{when: drive/run, nth: 0, clear: io}", "nth: 0 doesn't fit"),
        ("{when: run, clear: io}", "when: got 'run'"),
        ("{when: drive/rnu, clear: io}", "when: drive has no value 'rnu'"),
        ("{when: drive/run > 'a', clear: io}", "cannot be judged"),
        ("{at: 1s, clear: oi}", "clear: the rig has no bus or device 'oi'"),
        ("{at: 1s, restart: can0}", "restart: the rig has no device 'can0'"),
        ("{at: 1s, fault: can0 dorp}", "fault: can0: there is no fault 'dorp'"),
        ("{at: 1s, fault: can0 drop when=oi/x}", "no device 'oi'"),
        ("{at: 1s, send: {can0: 000-01}}", "send.can0: can0: '000-01' cannot be sent"),
        ("{at: 1s, send: {wires: 000#01}}", "on which a scenario sends nothing"),
        ("{at: 1s, set: {'message(can0, id=3)': true}}", "cannot be written"),
    ],
)
def test_a_wrong_step_is_refused_with_its_line(tmp_path: Path, step: str, mistake: str) -> None:
    with pytest.raises(ConfigError) as caught:
        played(tmp_path, f"- {step}\n")
    [found] = caught.value.mistakes
    assert found.line == 4
    assert mistake in f"{found.key}: {found.what}"


def test_a_key_is_released_before_what_happens_at_the_same_instant(tmp_path: Path) -> None:
    """It does not matter whether the next step was known when the key was pressed."""
    found = played(
        tmp_path,
        "- {at: 10ms, press: {drive/speed_set: 40}, hold: 20ms}\n- {at: 30ms, set: {drive/speed_set: 7}}\n",
    )
    assert instants_ms(found) == [
        ("drive/speed_set = 40 for 20 ms", 10.0),
        ("drive/speed_set = 0.0", 30.0),
        ("drive/speed_set = 7", 30.0),
    ]
