"""Scenarios in Python: the same steps, properties and reasons as in a file."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from fieldrig import MS, ArgumentError, ConfigError, S, UnmetError
from fieldrig.pytest_plugin import BranchMaker, RigMaker
from fieldrig_devices.scenarios import Scenario

LAB = Path(__file__).parents[3] / "configs" / "lab.yaml"


def lab() -> Scenario:
    scenario = Scenario(length=1 * S)
    scenario.set("drive/speed_set", 40)
    scenario.press("drive/run", hold=300 * MS, at=100 * MS)
    scenario.send("can0", "000#0105", when="drive/run", at=50 * MS)
    scenario.fault("sensor", "power_off duration_ms=100", when="message(can0, id=0)")
    scenario.never("tank/level < 0.1", name="the tank never runs dry")
    scenario.expect("io/nmt.state == operational", within=60 * MS, after="drive/run")
    scenario.stays("wires/pump.run", until="not drive/run", after="wires/pump.run", within=400 * MS)
    scenario.eventually("sensor/nmt.state == pre_operational", within=1 * S)
    return scenario


def test_it_plays_to_a_rig_and_to_a_branch_alike(fieldrig_rig: RigMaker, fieldrig_branch: BranchMaker) -> None:
    rig = fieldrig_rig(LAB)
    rig.run_until(1 * S)
    here, there = lab().run(rig), lab().run(fieldrig_branch(LAB, boot=1 * S))
    assert here.is_good
    assert not here.violations
    assert here.tracks == there.tracks
    assert here.tracks["drive/run"] == ((0, False), (100 * MS, True), (400 * MS, False))
    assert here.played.hash.partition(":")[0] != "0"


def test_every_reason_is_told_and_the_picture_is_there(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    scenario = lab()
    scenario.never("drive/run", longer=50 * MS)
    scenario.expect("io/nmt.state == stopped", within=20 * MS)
    scenario.restart("io", when="tank/level > 7")
    with pytest.raises(UnmetError) as caught:
        scenario.run(fieldrig_rig(LAB), picture=tmp_path / "lab.svg")
    told = caught.value.what.splitlines()
    what = "`io/nmt.state == stopped` was not true within 0.02 s of the begin"
    assert told[0] == f"expect io/nmt.state == stopped: at 0.02 s: {what}"
    assert "and never drive/run: at 0.15 s: `drive/run` was true for longer than 0.05 s" in told
    assert "and step: restart io: `tank/level > 7` was not true" in told
    assert "  0.1 s: step: drive/run = true for 300 ms" in told
    assert (tmp_path / "lab.svg").read_text().startswith("<svg")


def test_what_the_rig_does_not_have_is_refused_at_the_begin(fieldrig_rig: RigMaker) -> None:
    scenario = lab()
    scenario.never("tank/levle > 3")
    scenario.clear("oi")
    rig = fieldrig_rig(LAB)
    with pytest.raises(ConfigError, match="did you mean level") as caught:
        scenario.play(rig)
    assert [one.key for one in caught.value.mistakes] == ["properties.never tank/levle > 3", "steps[4].clear"]
    assert rig.now_ns == 0


WRONG: list[tuple[Callable[[Scenario], Any], str]] = [
    (lambda one: one.set("tank/level", [1]), "tank/level cannot be"),  # type: ignore[arg-type]
    (lambda one: one.set("", 1), "set cannot take"),
    (lambda one: one.set("tank/level", 1, at=0.5), "at cannot be 0.5"),  # type: ignore[arg-type]
    (lambda one: one.set("tank/level", 1, at=-1), "at cannot be -1"),
    (lambda one: one.press("drive/run", nth=2), "nth cannot be 2"),
    (lambda one: one.press("drive/run", when="a/b", nth=0), "nth cannot be 0"),
    (lambda one: one.press("drive/run", when="a"), "when 'a': got 'a'"),
    (lambda one: one.fault("io", "drop x y"), "is no fault"),
    (lambda one: one.fault("io", 5), "5 is no fault"),  # type: ignore[arg-type]
    (lambda one: one.never(7), "the condition 7"),  # type: ignore[arg-type]
    (lambda one: one.expect("a/b", within="1s"), "the time cannot be '1s'"),  # type: ignore[arg-type]
    (lambda one: one.stays("a/b", until=""), "until ''"),
    (lambda one: [one.never(text) for text in ("a/b", "a/b")], "two properties"),  # type: ignore[func-returns-value]
    (lambda one: one.play(None), "requires nothing"),  # type: ignore[arg-type]
    (lambda one: one.never("a/b") or one.play(7), "cannot be played to 7"),  # type: ignore[arg-type, func-returns-value]
]


@pytest.mark.parametrize(("call", "what"), WRONG)
def test_wrong_arguments_are_refused_with_what_was_expected(call: Callable[[Scenario], Any], what: str) -> None:
    with pytest.raises(ArgumentError, match=r"expected|give") as caught:
        call(Scenario())
    assert what in caught.value.what
