"""The things that may happen in a search: faults by pattern, keys, values, and other worlds."""

import json
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from st_tests import LAMP_RIG
from typer.testing import CliRunner

from fieldrig.clock import MS
from fieldrig.config.rig_file import load
from fieldrig.errors import RigError
from fieldrig.virtual.rig import Rig
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.choices import Choice, Span
from fieldrig_devices.search.command import app
from fieldrig_devices.search.minimal import minimal
from fieldrig_devices.search.piece import Piece
from fieldrig_devices.search.plan import EVERY_FAULT, load_plan
from fieldrig_devices.search.vary import VarySettings, choices_of

pytestmark = pytest.mark.lean

CONFIGS = Path(__file__).parents[3] / "configs"


@pytest.fixture
def lab() -> Iterator[Rig]:
    with Rig(load(CONFIGS / "lab.yaml", ("time=virtual",))) as rig:
        rig.run_until(100 * MS)
        yield rig


def chosen(rig: Rig, **given: Any) -> list[Choice]:
    return list(choices_of(rig, [VarySettings.model_validate(given)]))


def kinds(choices: list[Choice]) -> set[tuple[str, str]]:
    return {(one.where, one.values[0]["what"]) for one in choices}


def test_every_fault_that_the_kinds_of_a_rig_have(lab: Rig) -> None:
    found = kinds(list(choices_of(lab, [EVERY_FAULT])))
    missing = [
        (name, what) for name, bus in lab.buses.items() for what in type(bus).fault_models if (name, what) not in found
    ]
    models = {name: one.cls.fault_models for name, one in lab.config.devices.items()}
    missing += [(name, what) for name, known in models.items() for what in known if (name, what) not in found]
    assert missing == []
    assert ("sensor", "power_off") in found


@pytest.mark.parametrize(
    ("faults", "expected"),
    [
        ("tank", {("tank", what) for what in ("power_off", "leak", "blocked_outlet", "stuck_sensor", "stuck_switch")}),
        ({"where": "can*", "kinds": ["drop", "dup*"]}, {("can0", "drop"), ("can0", "duplicate")}),
        ({"where": "canopen.node", "kinds": "silent"}, {("io", "silent"), ("sensor", "silent")}),
        ({"where": "buses", "kinds": "drop"}, {("can0", "drop"), ("mb_tcp", "drop"), ("mb_rtu", "drop")}),
        (
            {"where": ["devices"], "kinds": "power_off"},
            {(one, "power_off") for one in ("tank", "io", "sensor", "drive")},
        ),
    ],
)
def test_faults_by_pattern(lab: Rig, faults: object, expected: set[tuple[str, str]]) -> None:
    assert kinds(chosen(lab, faults=faults)) == expected


def test_a_fault_in_its_forms_times_and_milestones(lab: Rig) -> None:
    wanted = {"where": "wires", "kinds": "stuck", "durations": ["20ms"], "when": ["tank/level > 1.0", "drive/run"]}
    [choice] = chosen(lab, faults=wanted)
    assert {one["wire"] for one in choice.values} >= {"pump.run", "tank.high", "tank.low"}
    assert {one["when"] for one in choice.values} == {"tank/level > 1.0", "drive/run"}
    assert {one["duration_ms"] for one in choice.values} == {20.0}
    [one_wire] = chosen(lab, faults={**wanted, "with": {"wire": "tank.low", "value": True}, "when": []})
    assert one_wire.values == ({"what": "stuck", "duration_ms": 20.0, "wire": "tank.low", "value": True},)


def test_each_fault_is_taken_by_the_rig(lab: Rig) -> None:
    for choice in choices_of(lab, [EVERY_FAULT]):
        for fault in choice.values[:3]:
            lab.add_fault(choice.where, fault)


def test_keys_and_values_by_pattern_list_and_span(lab: Rig) -> None:
    [run, stop] = chosen(lab, press={"drive/r*n": [True, False], "drive/run": True}, hold=["20ms", "1s"])
    assert run == Choice("press", "drive/run", (True, False), holds_ns=(20 * MS, 1000 * MS))
    assert stop.values == (True,)
    [speed] = chosen(lab, set={"drive/speed_set": {"from": 5, "to": 60}})
    assert speed.span == Span(5, 60)
    assert [act.value for act in speed.all(0)] == [5, 60]
    assert [one.where for one in chosen(lab, restart="canopen.*")] == ["io", "sensor"]


@pytest.mark.parametrize(
    ("given", "what"),
    [
        ({"faults": "tnak"}, "tank"),
        ({"faults": {"where": "tank", "kinds": "laek"}}, "leak"),
        ({"restart": "oi"}, "io"),
        ({"press": {"drive/xyz*": True}}, "drive"),
    ],
)
def test_what_the_rig_does_not_have_is_refused(lab: Rig, given: Any, what: str) -> None:
    with pytest.raises(RigError) as caught:
        chosen(lab, **given)
    assert what in str(caught.value) + str(caught.value.remedy)


@given(st.integers(-5, 5), st.integers(0, 50), st.booleans(), st.integers())
def test_dice_stay_within_a_span(low: int, size: int, is_real: bool, seed: int) -> None:
    span = Span(float(low), float(low + size)) if is_real else Span(low, low + size)
    act = Choice("set", "a/b", span=span).thrown(Random(seed), 7)
    assert span.low <= act.value <= span.high  # type: ignore[operator]
    assert type(act.value) is type(span.low)


def test_values_become_plain() -> None:
    speed, mode = Choice("set", "a/speed", span=Span(2, 100)), Choice("set", "a/mode", (1, 2, 3))
    acts = (Act(0, "set", "a/speed", 77), Act(0, "set", "a/mode", 3))

    def fails(some: tuple[Act, ...]) -> bool:
        values = {act.where: act.value for act in some}
        return values.get("a/speed", 0) >= 41 and values.get("a/mode", 0) >= 2  # type: ignore[operator]

    assert [act.value for act in minimal(acts, fails, [speed, mode])] == [41, 2]


PROGRAM = """\
VAR_GLOBAL limit : INT := 3; presses : INT; END_VAR
PROGRAM PLC_PRG
VAR switch AT %IX0.0 : BOOL; lamp AT %QX0.0 : BOOL; edge : R_TRIG; END_VAR
edge(CLK := switch);
IF edge.Q THEN presses := presses + 1; END_IF
lamp := presses >= limit;
END_PROGRAM
"""
TANK = """\
  tank:
    kind: plant.tank
    links: {wires: wires}
    area_m2: 1
    height_m: 2
    outlet_area_m2: 0.0002
    pump_flow_m3_per_s: 0.001
    initial_level_m: 0.3
"""
PROPERTIES = """\
after: 200ms
for: 300ms
steps: [{at: 50ms, press: {wires/switch.on: true}, hold: 50ms}]
properties: {dark: {never: wires/lamp.on}}
"""
PRESSES = "vary: [{press: {wires/switch.on: true}, hold: 20ms}]\n"


@pytest.mark.long
def test_a_rig_and_a_file_of_properties(tmp_path: Path) -> None:
    (tmp_path / "rig.yaml").write_text(LAMP_RIG)
    (tmp_path / "lamp.st").write_text(PROGRAM)
    (tmp_path / "properties.yaml").write_text(PROPERTIES + PRESSES)
    corpus = tmp_path / "c.sqlite"
    options = ["--strategy", "swarm", "--most", "20", "-j", "1", "--corpus", str(corpus), "--seed", "3"]
    done = CliRunner().invoke(
        app, [str(tmp_path / "rig.yaml"), "--property", str(tmp_path / "properties.yaml"), *options]
    )
    assert done.exit_code == 1, done.output
    assert "dark: at" in done.output
    [finding, *_] = json.loads(CliRunner().invoke(app, ["show", str(corpus), "--json"]).output)
    number = str(finding["number"])
    replayed = CliRunner().invoke(app, ["replay", str(corpus), number])
    assert replayed.exit_code == 1, replayed.output
    assert "each message is the same" in replayed.output
    assert "in the 50 ms before:" in replayed.output
    assert CliRunner().invoke(app, ["minimise", str(corpus), number]).output.endswith("1 finding\n")
    (tmp_path / "lamp.st").write_text(PROGRAM.replace("presses >= limit", "FALSE"))
    fixed = CliRunner().invoke(app, ["replay", str(corpus)])
    assert fixed.exit_code == 0, fixed.output
    assert "holds now" in fixed.output


LAB = f"""\
rig: {CONFIGS / "lab.yaml"}
for: 100ms
properties: {{off: {{never: drive/run}}}}
"""


@pytest.mark.long
@pytest.mark.parametrize(
    ("vary", "what"),
    [
        ("{set: {drive/rnu: true}}", "rnu"),
        ("{set: {drive/run: 7}}", "run"),
        ("{fault: tank laek}", "laek"),
        ("{send: {can1: 123#00}}", "can1"),
    ],
)
def test_what_cannot_happen_is_refused_before_the_search(tmp_path: Path, vary: str, what: str) -> None:
    (tmp_path / "plan.yaml").write_text(f"{LAB}vary: [{vary}]\n")
    with Bench(load_plan(tmp_path / "plan.yaml")) as bench, pytest.raises(RigError, match=what):
        assert bench.choices


@pytest.mark.long
def test_what_is_refused_in_a_run_ends_the_run_only(tmp_path: Path) -> None:
    (tmp_path / "plan.yaml").write_text(f"{LAB}vary: [{{restart: io}}]\n")
    with Bench(load_plan(tmp_path / "plan.yaml")) as bench:
        played = bench.play(Piece((Act(50 * MS, "fault", "tank", {"what": "laek"}),), 0, 100 * MS))
    assert "laek" in played.refused
    assert played.violations == ()


@pytest.mark.long
def test_other_worlds_are_swept_too(tmp_path: Path) -> None:
    (tmp_path / "rig.yaml").write_text(LAMP_RIG.replace("lamp.st\n", "lamp.st\n" + TANK))
    (tmp_path / "lamp.st").write_text(PROGRAM)
    level = "worlds: {devices.tank.initial_level_m: [0.2, 0.9]}\nvary: [{restart: tank}]\n"
    (tmp_path / "plan.yaml").write_text(
        f"rig: rig.yaml\n{PROPERTIES.replace('never: wires/lamp.on', 'always: tank/level < 0.5')}{level}"
    )
    corpus = tmp_path / "c.sqlite"
    done = CliRunner().invoke(
        app, ["run", str(tmp_path / "plan.yaml"), "--strategy", "sweep", "--most", "3", "--corpus", str(corpus)]
    )
    assert done.exit_code == 1, done.output
    assert "with devices.tank.initial_level_m=0.9" in done.output
    assert "1 finding" in done.output
