"""Every finding that a search writes is a scenario that repeats it to the last bit, and a test that fails."""

import subprocess
import sys
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS
from fieldrig.errors import ConfigError
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.running import played
from fieldrig_devices.scenarios.scenario_file import Scenario, load_scenario
from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.corpus import Corpus, Finding
from fieldrig_devices.search.crew import LocalCrew
from fieldrig_devices.search.findings import scenario_text, write
from fieldrig_devices.search.plan import load_plan
from fieldrig_devices.search.search import Limits, Search

pytestmark = pytest.mark.lean

RIG = """\
time: virtual
buses: {wires: {kind: wires.virtual}}
devices: {one: {kind: "MODULE:Moody", links: {wires: wires}}}
"""
DEVICE = """
from fieldrig import Device, Link, Point
from fieldrig_bus.wires import Signal

class Moody(Device):
    about = "refuses some values, which depends on those before"

    def __init__(self, clock, wires: Link[Signal]):
        self._clock, self._wires, self._level, self._mode, self._sum = clock, wires, 0.0, "idle", 0
        wires.on_receive(self._on_signal, ["switch.on"])

    def start(self):
        self._clock.call_at(self._clock.now_ns() + 7_000_000, self._tick)

    def points(self):
        return {
            "level": Point(lambda: self._level, write=self._write_level),
            "mode": Point(lambda: self._mode, write=self._write_mode),
            "sum": Point(lambda: self._sum),
        }

    def _write_level(self, value):
        if self._mode != "idle" and value > 5:
            raise ValueError("not while it is not idle")
        self._level = value

    def _write_mode(self, value):
        if self._level > 8:
            raise ValueError("not at a high level")
        self._mode = value

    def _on_signal(self, signal):
        self._sum += 1

    def _tick(self):
        self._sum += int(self._level)
        self._wires.send(Signal("moody.sum", self._sum))
        self._clock.call_at(self._clock.now_ns() + 7_000_000, self._tick)
"""
VARY = [
    "{set: {one/level: [2.5, 4, 9.0]}}",
    "{press: {one/level: [3, 9]}, hold: [5ms, 20ms]}",
    """{set: {one/mode: ["it's \\"on\\"", "off", "null"]}}""",
    """{press: {one/mode: ["it's \\"on\\"", "1"]}, hold: 30ms}""",
    "{set: {wires/switch.on: [true, false]}}",
    "{press: {wires/switch.on: true}, hold: [10ms, 20ms]}",
    "{restart: one}",
    "{faults: {where: one, durations: 20ms}}",
    "{faults: {where: wires, kinds: stuck, durations: 20ms, with: {wire: moody.sum}, when: 'one/level > 2'}}",
]
RULES = [
    "high: {never: one/level > 3}",
    "on: {never: 'one/mode != \"idle\"', longer: 15ms}",
    "'no: null': {always: one/sum < 12}",
    "back: {eventually: one/level < 3 and one/sum > 2, within: 20ms}",
]
PLAN = """\
rig: rig.yaml
after: 10ms
for: 200ms
steps:
  - {at: 20ms, press: {wires/switch.on: true}, hold: 40ms}
  - {when: one/sum > 4, at: 10ms, press: {wires/switch.on: true}, hold: 10ms}
  - {at: 60ms, set: {wires/switch.on: false}}
"""


def planned(folder: Path, vary: list[str], rules: list[str]) -> Path:
    module = f"moody_{folder.name}"  # a module is imported once in a process
    (folder / "rig.yaml").write_text(RIG.replace("MODULE", module))
    (folder / f"{module}.py").write_text(DEVICE)
    lines = ["vary:", *(f"  - {one}" for one in vary), "properties:", *(f"  {one}" for one in rules)]
    (folder / "plan.yaml").write_text(PLAN + "\n".join(lines) + "\n")
    return folder / "plan.yaml"


def found(file: Path, seed: int, most: int) -> tuple[Scenario, list[Finding]]:
    plan, corpus = load_plan(file), Corpus(None)
    with Bench(plan) as bench, LocalCrew(bench, 1) as crew:
        Search(plan, bench, crew, corpus, seed).go(["swarm", "archive"], Limits(600, most), lambda _: None)
    return plan.scenario, corpus.findings()


@pytest.mark.long
@pytest.mark.parametrize("seed", range(6))
def test_the_findings_of_any_plan_are_repeated_to_the_last_bit(tmp_path: Path, seed: int) -> None:
    dice = Random(seed)
    vary, rules = dice.sample(VARY, dice.randint(2, 5)), dice.sample(RULES, dice.randint(1, 3))
    scenario, findings = found(planned(tmp_path, vary, rules), seed, 24)
    for finding, file in zip(findings, write(scenario, findings, tmp_path / "found"), strict=True):
        again = played(file).played
        assert again.hash_then == finding.hash
        told = [(one.property, one.at_ns, one.what) for one in again.violations]
        assert (finding.property, finding.at_ns, finding.what) in told
        assert min(at_ns for _, at_ns, _ in told) == finding.at_ns


@pytest.mark.long
def test_a_finding_of_keys_alone_of_which_one_is_refused_fails_as_a_test_too(tmp_path: Path) -> None:
    vary = ["{set: {one/level: [4]}}", """{set: {one/mode: "off"}}"""]
    scenario, [finding] = found(planned(tmp_path, vary, ["high: {never: one/level > 3}"]), 1, 10)
    assert {act.verb for act in finding.acts} == {"set"}
    refused = (Act(0, "set", "one/mode", "off"), Act(0, "set", "one/level", 9), *finding.acts)
    write(scenario, [finding._replace(acts=refused)], tmp_path / "found")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path / "found")]
    shown = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert shown.returncode == 1, shown.stdout
    assert f"UnmetError: {finding.property}" in shown.stdout
    assert "ControlError" not in shown.stdout


@pytest.mark.long
def test_another_phase_of_the_cycles_is_a_world_and_its_finding_repeats_it(tmp_path: Path) -> None:
    """The device ticks each 7 ms: in 30 ms from 10 ms on four times, and from 13.9 ms on five times."""
    file = planned(tmp_path, ["{clear: one}"], ["few: {always: one/sum < 5}"])
    text = PLAN.replace("for: 200ms", "for: 30ms\nworlds: {seed: [3], after: [10.5ms, 13.9ms]}")
    steps = "  - {at: 0s, set: {one/level: 1}}\n"
    file.write_text(text[: text.index("  - {at: 20ms")] + steps + file.read_text()[file.read_text().index("vary:") :])
    plan, corpus = load_plan(file), Corpus(None)
    with Bench(plan) as bench, LocalCrew(bench, 1) as crew:
        Search(plan, bench, crew, corpus, 1).go(["sweep"], Limits(600, 3), lambda _: None)
    [finding] = corpus.findings()
    assert (finding.world, finding.acts) == (("after=13.9ms",), ())
    [scenario] = write(plan.scenario, [finding], tmp_path / "found")
    assert load_scenario(scenario).after_ns == 13_900_000
    assert played(scenario).played.hash_then == finding.hash


@pytest.mark.parametrize(
    ("worlds", "what"),
    [
        ("after: [7]", "'7' is not a duration"),
        ("jitter: [5ms]", "only a master wakes up late"),
        ("after: [1e30s]", "'1e30s' is too long"),
        ("seed: []", r"worlds.seed: \[\] doesn't fit"),
    ],
)
def test_a_time_of_a_world_that_makes_no_sense_is_told(tmp_path: Path, worlds: str, what: str) -> None:
    file = planned(tmp_path, ["{clear: one}"], ["few: {always: one/sum < 5}"])
    file.write_text(file.read_text().replace("for: 200ms", f"for: 200ms\nworlds: {{{worlds}}}"))
    with pytest.raises(ConfigError, match=what):
        load_plan(file)


@pytest.mark.parametrize("entry", ["{restart: []}", "{clear: []}", "{send: {can0: []}}", "{faults: {kinds: []}}"])
def test_an_entry_that_lets_nothing_happen_is_refused(tmp_path: Path, entry: str) -> None:
    with pytest.raises(ConfigError, match="expected a list of at least 1 item"):
        load_plan(planned(tmp_path, [entry], ["few: {always: one/sum < 5}"]))


@pytest.mark.long
def test_a_mistake_of_a_world_names_the_world(tmp_path: Path) -> None:
    """It had the line of the rig file only, which is right by itself."""
    file = planned(tmp_path, ["{clear: one}"], ["few: {always: one/sum < 5}"])
    file.write_text(file.read_text().replace("for: 200ms", "for: 200ms\nworlds: {devices.one.levle: [1]}"))
    with (
        Bench(load_plan(file)) as bench,
        pytest.raises(ConfigError, match=r"in the world devices\.one\.levle=1 of the plan: "),
    ):
        bench.check()


TEXTS = st.text(st.characters(codec="utf-8"), max_size=8)
VALUES: st.SearchStrategy[Any] = st.one_of(
    st.booleans(), st.integers(-(10**12), 10**12), st.floats(allow_nan=False, allow_infinity=False), TEXTS
)
FAULTS = st.fixed_dictionaries(
    {"what": st.sampled_from(["drop", "power_off"])},
    optional={"duration_ms": st.integers(1, 9000).map(str), "when": TEXTS, "text": TEXTS},
)
PLACES = st.sampled_from(["one/level", "one/6041:00", "wires/a.b c", "feeder/program:PLC_PRG.x[1]"])
TIMES = st.integers(0, 3_000_000_000)
ACTS = st.one_of(
    st.tuples(TIMES, st.just("set"), PLACES, VALUES),
    st.tuples(TIMES, st.just("press"), PLACES, VALUES, TIMES),
    st.tuples(TIMES, st.just("fault"), st.just("one"), FAULTS),
    st.tuples(TIMES, st.just("send"), st.just("can0"), TEXTS),
    st.tuples(TIMES, st.sampled_from(["clear", "restart"]), st.just("one")),
).map(lambda fields: Act(*fields))


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plain")
    (folder / "rig.yaml").write_text(RIG)
    text = "rig: rig.yaml\nfor: 4s\nsteps: []\nproperties: {high: {never: one/level > 3}}\n"
    (folder / "it.yaml").write_text(text)
    return folder


@given(st.lists(ACTS, max_size=4))
@settings(deadline=None, max_examples=60)
def test_any_actions_are_read_as_they_were_written(plain: Path, acts: list[Act]) -> None:
    scenario = load_scenario(plain / "it.yaml")
    finding = Finding(1, "high", tuple(acts), (), 4000 * MS, 0, "it is\ntrue")
    (plain / "finding.yaml").write_text(scenario_text(scenario, finding, plain), encoding="utf-8")
    again = load_scenario(plain / "finding.yaml")
    assert again.schedule == tuple(sorted(acts, key=lambda act: act.at_ns))
    assert [(type(act.value), act.hold_ns) for act in again.schedule] == [
        (type(act.value), act.hold_ns) for act in sorted(acts, key=lambda act: act.at_ns)
    ]
    assert again.forgives
