"""Plans with mistakes: each is named with its file, its line and its key, before anything is searched."""

from pathlib import Path

import pytest

from fieldrig.errors import ConfigError
from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.plan import load_plan

pytestmark = pytest.mark.lean  # a check tries what a plan varies in branches

LAB = Path(__file__).parents[3] / "configs" / "lab.yaml"
PLAN = f"""\
rig: {LAB}
for: 1s
steps:
  - {{at: 100ms, set: {{drive/run: true}}}}
properties:
  it runs: {{always: drive/run, after: drive/run}}
"""
GOOD = "vary: [{restart: io}]\n"
WRONG = [
    ("vary:\n  - {restart: ioo}\n", "vary[0].restart", "did you mean io?"),
    ("vary:\n  - {restart: 'x*'}\n", "vary[0].restart", "there are: can0"),
    ("vary:\n  - {restart: can0}\n", "vary[0].restart", "can0 is no device"),
    ("vary:\n  - {restart: [io, buses]}\n", "vary[0].restart", "buses is no device"),
    ("vary:\n  - {clear: can7}\n", "vary[0].clear", "did you mean can0?"),
    ("vary:\n  - {fault: tank leek}\n", "vary[0].fault", "did you mean leak?"),
    ("vary:\n  - {faults: tonk}\n", "vary[0].faults", "did you mean tank?"),
    ("vary:\n  - {faults: {where: buses, kinds: [dorp]}}\n", "vary[0].faults", "did you mean drop?"),
    ("vary:\n  - {faults: {where: tank, when: [tank/levle > 1]}}\n", "vary[0].faults", "did you mean level?"),
    ("vary:\n  - {faults: {where: wires, with: {wirre: tank.level}}}\n", "vary[0].faults", "did you mean wire?"),
    ("vary:\n  - {press: {drive/rnu: true}}\n", "vary[0].press", "did you mean run?"),
    ("vary:\n  - {set: {drive/speed_set: 5000}}\n", "vary[0].set", "expected a number from 0 to 100"),
    ("vary:\n  - {set: {tank/inflow: 5}}\n", "vary[0].set", "can only be read"),
    ("vary:\n  - {send: {can0: zz}}\n", "vary[0].send", "expected a frame such as"),
    ("vary:\n  - {restart: io, hold: 1s}\n", "vary[0].hold", "only `press` has `hold`"),
    (f"{GOOD}states: [tank/lvel]\n", "states[0]", "did you mean level?"),
    (f"{GOOD}edges: [wires/nope]\n", "edges[0]", "there are: tank.level"),
    (f"{GOOD}worlds: {{devices.tnk.area_m2: [1]}}\n", "worlds.devices.tnk.area_m2[0]", "did you mean tank?"),
    (f"{GOOD}worlds: {{devices.tank.area_m2: [0.25, -1]}}\n", "worlds.devices.tank.area_m2[1]", "expected a number"),
    (f"{GOOD}overrides: [devices.tank.hight_m=1]\n", "overrides[0]", "did you mean height_m?"),
]  # fmt: skip


def mistakes_of(file: Path) -> ConfigError:
    with pytest.raises(ConfigError) as caught, Bench(load_plan(file)) as bench:
        bench.check()
    return caught.value


@pytest.mark.parametrize(("words", "key", "remedy"), WRONG)
def test_a_mistake_that_only_the_rig_shows_has_its_line(tmp_path: Path, words: str, key: str, remedy: str) -> None:
    file = tmp_path / "plan.yaml"
    file.write_text(PLAN + words)
    [mistake] = mistakes_of(file).mistakes
    assert (mistake.file, mistake.line, mistake.key) == (str(file), len((PLAN + words).splitlines()), key)
    assert remedy in f"{mistake.what} {mistake.remedy}"


def test_all_mistakes_are_named_at_once(tmp_path: Path) -> None:
    file = tmp_path / "plan.yaml"
    file.write_text(f"{PLAN}vary:\n  - {{restart: ioo}}\n  - {{fault: tank leek}}\nstates: [tank/lvel]\n")
    assert [one.key for one in mistakes_of(file).mistakes] == ["vary[0].restart", "vary[1].fault", "states[0]"]


def test_a_place_of_the_scenario_has_its_line_too(tmp_path: Path) -> None:
    file = tmp_path / "plan.yaml"
    file.write_text(PLAN.replace("always: drive/run", "always: drive/rum") + GOOD)
    [mistake] = mistakes_of(file).mistakes
    assert (mistake.line, mistake.key, mistake.remedy) == (6, "properties.it runs.always", "did you mean run?")


def test_a_wire_may_stand_in_several_entries(tmp_path: Path) -> None:
    file = tmp_path / "plan.yaml"
    entries = "[{set: {wires/tank.high: true}}, {press: {wires/tank.high: false}}, {restart: io}]"
    file.write_text(f"{PLAN}vary: {entries}\n")
    with Bench(load_plan(file)) as bench:
        bench.check()
        assert [choice.verb for choice in bench.choices] == ["set", "press", "restart"]
