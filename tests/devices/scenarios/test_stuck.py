"""A device that computes without end breaks a property of every rig, so that no worker of a search hangs."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from fieldrig.virtual import stuck
from fieldrig_devices.scenarios.guard import TIME_PASSES
from fieldrig_devices.scenarios.running import played
from fieldrig_devices.search.command import app as search_app

pytestmark = pytest.mark.long

RIG = """\
time: virtual
buses: {wires: {kind: wires.virtual}}
devices: {one: {kind: "MODULE:Greedy", links: {wires: wires}}}
"""
DEVICE = """
from fieldrig import Device, Link, Point
from fieldrig_bus.wires import Signal

class Greedy(Device):
    about = "computes without end when it is pressed"

    def __init__(self, clock, wires: Link[Signal]):
        self._clock = clock

    def points(self):
        return {"pressed": Point(lambda: False, write=self._press)}

    def _press(self, value):
        self._clock.call_at(self._clock.now_ns() + 1_000_000, self._compute)

    def _compute(self):
        WORK
"""
ENDLESS = "while True: pass"
HASTY = "self._clock.call_at(self._clock.now_ns() + 1, self._compute)"


def written(folder: Path, work: str, text: str) -> Path:
    module = f"greedy_{folder.name}"  # a module is imported once in a process
    (folder / "rig.yaml").write_text(RIG.replace("MODULE", module))
    (folder / f"{module}.py").write_text(DEVICE.replace("WORK", work))
    (folder / "it.yaml").write_text(f"rig: rig.yaml\nfor: 50ms\n{text}properties: {{no: {{never: one/pressed}}}}\n")
    return folder / "it.yaml"


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stuck, "LIMIT_S", 0.4)


@pytest.mark.parametrize("work", [ENDLESS, HASTY])
def test_a_device_that_computes_without_end_is_a_violation_with_its_line(tmp_path: Path, work: str) -> None:
    file = written(tmp_path, work, "steps: [{at: 20ms, set: {one/pressed: true}}]\n")
    [found] = played(file).played.violations
    assert found.property == TIME_PASSES
    assert found.at_ns // 1_000_000 == 21
    assert found.what.startswith("it has computed for 0.4 s and no time has passed (")
    if work == ENDLESS:
        assert f"{next(tmp_path.glob('greedy_*.py')).name}:18 in _compute)" in found.what


def test_a_search_goes_on_after_a_run_that_does_not_end(tmp_path: Path) -> None:
    vary = "vary: [{press: {one/pressed: true}, hold: 5ms}]\n"
    file = written(tmp_path, ENDLESS, vary)
    options = ["--strategy", "swarm", "--most", "2", "--corpus", str(tmp_path / "c"), "--findings", str(tmp_path)]
    shown = CliRunner().invoke(search_app, ["run", str(file), *options])
    assert shown.exit_code == 1, shown.output
    assert f"1. {TIME_PASSES}: at" in shown.output
    assert [one.property for one in played(tmp_path / "finding-1.yaml").played.violations] == [TIME_PASSES]
