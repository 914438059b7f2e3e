"""Conditions of faults in a rig file: `fieldrig check` refuses those that can never be met, with the nearest name."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.errors import ConfigError

ROOT = Path(__file__).parents[3]
RIG = """time: virtual
buses:
  can0:
    kind: can.virtual
    faults:
      - {what: drop}
      - what: drop
        when: %s
  wires: {kind: wires.hub}
devices:
  sensor: {kind: canopen.node, node_id: 6, eds: EDS, links: {can: can0}}
  tank:
    kind: plant.tank
    area_m2: 0.25
    height_m: 2.0
    outlet_area_m2: 0.0002
    pump_flow_m3_per_s: 0.001
    links: {wires: wires}
    faults: [{what: leak, when: %s}]
"""
MET = "tank/level > 1.5", "sensor/nmt.state == operational"


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def checked(of_bus: str, of_device: str, time: str = "virtual") -> list[str]:
    """Return the mistakes that `fieldrig check` finds."""
    text = RIG.replace("EDS", str(ROOT / "configs/eds/io32.eds")).replace("virtual", time, 1) % (of_bus, of_device)
    Path("rig.yaml").write_text(text.replace("can.virtual", "can.hub") if time == "real" else text, encoding="utf-8")
    wrong = CliRunner().invoke(app, ["check", "rig.yaml"]).exception
    return [str(mistake) for mistake in wrong.mistakes] if isinstance(wrong, ConfigError) else []


def test_conditions_that_can_be_met_are_no_mistake() -> None:
    assert checked(*MET) == []


@pytest.mark.parametrize(
    ("condition", "what", "remedy"),
    [
        ("tan/level > 1.5", "there is no device 'tan'", "did you mean tank?"),
        ("tank/levle > 1.5", "tank has no value 'levle'", "did you mean level?"),
        ("sensor/nmt.state == operatonal", "sensor/nmt.state is never 'operatonal'", "did you mean operational?"),
        ("sensor/nmt.state == 5", "sensor/nmt.state is never 5", "there are: initialising, stopped, operational"),
        ("tank/high > 1", "tank/high is never > 1", "expected true or false"),
        ("tank/level > full", "tank/level is never 'full'", "expected a number, such as 0.0"),
    ],
)
def test_what_does_not_exist_is_refused_with_its_line(condition: str, what: str, remedy: str) -> None:
    of_bus, of_device = checked(condition, MET[1]), checked(MET[0], condition)
    assert len(of_bus) == len(of_device) == 1
    assert of_bus[0].startswith(f"rig.yaml:8: buses.can0.faults[1].when: {what}\n    {remedy}")
    assert of_device[0].startswith(f"rig.yaml:19: devices.tank.faults[0].when: {what}\n    {remedy}")


@pytest.mark.parametrize(("of_bus", "of_device"), [MET, ("sensor/nmt.state == operational", "tank/level > 1.5")])
def test_conditions_on_devices_of_any_process_are_no_mistake_in_real_time(of_bus: str, of_device: str) -> None:
    assert checked(of_bus, of_device, time="real") == []
