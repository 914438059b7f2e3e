"""A device that raises, and devices that answer each other without end, break a property of every rig."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from fieldrig.errors import ConfigError
from fieldrig_devices.scenarios.command import app
from fieldrig_devices.scenarios.play import NOTHING_RAISES
from fieldrig_devices.scenarios.running import played
from fieldrig_devices.search.command import app as search_app

pytestmark = pytest.mark.long

RIG = """\
time: virtual
buses: {can0: {kind: can.virtual, bitrate: 500000}, wires: {kind: wires.virtual}}
devices:
  one: {kind: "MODULE:Fragile", links: {wires: wires}}
  two: {kind: "MODULE:Fragile", links: {wires: wires}}
"""
DEVICE = """
from fieldrig import Device, Link, Point, Settings
from fieldrig_bus.wires import Signal

class FragileSettings(Settings):
    pass

class Fragile(Device):
    about = "raises after some presses"

    def __init__(self, clock, settings: FragileSettings, wires: Link[Signal]):
        self._presses, self._limit, self._wires, self._clock = 0, 3, wires, clock

    def points(self):
        return {"pressed": Point(lambda: bool(self._presses % 2), write=self._press)}

    def _press(self, value):
        self._presses += value
        if self._presses >= self._limit:
            self._clock.call_at(self._clock.now_ns() + 1_000_000, lambda: [][0])
"""
SCENARIO = """\
rig: rig.yaml
for: 500ms
steps: []
properties: {not both: {never: one/pressed and two/pressed}}
"""


def written(folder: Path, text: str) -> Path:
    module = f"fragile_{folder.name}"  # a module is imported once in a process
    (folder / "rig.yaml").write_text(RIG.replace("MODULE", module))
    (folder / f"{module}.py").write_text(DEVICE)
    (folder / "it.yaml").write_text(text)
    return folder / "it.yaml"


def test_a_device_that_raises_is_a_violation_with_its_line(tmp_path: Path) -> None:
    steps = "".join(f"  - {{at: {ms}ms, set: {{one/pressed: true}}}}\n" for ms in (100, 200, 300))
    file = written(tmp_path, SCENARIO.replace("steps: []\n", f"steps:\n{steps}"))
    [found] = played(file).played.violations
    assert (found.property, found.at_ns) == (NOTHING_RAISES, 301_000_000)
    assert "IndexError: list index out of range (fragile_" in found.what
    assert ".py:20)" in found.what
    shown = CliRunner().invoke(app, ["run", str(file)])
    assert shown.exit_code == 1
    assert f"FAILED  {NOTHING_RAISES}" in shown.output


def test_a_search_finds_the_history_that_makes_a_device_raise(tmp_path: Path) -> None:
    file = written(tmp_path, f"{SCENARIO}vary:\n  - {{press: {{one/pressed: true}}, hold: 5ms}}\n")
    options = ["--strategy", "swarm", "--most", "40", "--corpus", str(tmp_path / "c"), "--findings", str(tmp_path)]
    shown = CliRunner().invoke(search_app, ["run", str(file), *options])
    assert shown.exit_code == 1, shown.output
    assert f"1. {NOTHING_RAISES}: at" in shown.output
    assert [one.property for one in played(tmp_path / "finding-1.yaml").played.violations] == [NOTHING_RAISES]


def test_a_key_of_a_device_without_power_does_nothing(tmp_path: Path) -> None:
    steps = (
        "  - {at: 100ms, fault: one power_off duration_ms=300}\n"
        "  - {at: 150ms, press: {one/pressed: true}, hold: 50ms}\n"
        "  - {at: 200ms, set: {one/pressed: true}}\n"
        "  - {at: 210ms, restart: one}\n"
    )
    file = written(tmp_path, SCENARIO.replace("steps: []\n", f"steps:\n{steps}"))
    outcome = played(file).played
    assert outcome.violations == ()
    assert [value for _, value in outcome.tracks["one/pressed"]] == [False]


def test_a_value_that_is_refused_after_a_restart_is_a_consequence_and_no_mistake(tmp_path: Path) -> None:
    text = SCENARIO.replace("steps: []\n", "steps:\n  - {at: 200ms, set: {one/pressed: true}}\n")
    file = written(tmp_path, text)
    module = next(tmp_path.glob("fragile_*.py"))
    module.write_text(module.read_text().replace("self._presses += value", "raise ValueError('not now')"))
    with pytest.raises(ConfigError, match=r"it\.yaml:4: steps\[0\]\.set\.one/pressed: .*not now"):
        played(file)
    disturbed = "  - {at: 100ms, restart: one}\n  - {at: 200ms"
    file.write_text(file.read_text().replace("  - {at: 200ms", disturbed))
    assert played(file).played.violations == ()
