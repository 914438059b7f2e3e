"""The law of faults over all kinds: each takes faults, or says why nothing of it can fail; and all have one form."""

import json
from importlib.metadata import entry_points
from typing import Any, Final

import pytest
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.config import kinds
from fieldrig.faults.faults import Timed

BUSES: Final = sorted(point.name for point in entry_points(group="fieldrig.buses"))
DEVICES: Final = sorted(point.name for point in entry_points(group="fieldrig.devices"))


def found(kind: str) -> Any:
    return kinds.find_bus(kind) if kind in BUSES else kinds.find_device(kind)


@pytest.mark.parametrize("kind", [*BUSES, *DEVICES])
def test_each_kind_takes_faults_or_says_why_nothing_can_fail(kind: str) -> None:
    cls = found(kind)
    assert not (cls.fault_models and cls.no_faults)
    assert cls.fault_models or cls.no_faults


@pytest.mark.parametrize("kind", [*BUSES, *DEVICES])
def test_all_faults_have_the_one_form(kind: str) -> None:
    for what, model in found(kind).fault_models.items():
        assert issubclass(model, Timed)
        assert {"what", "start_ms", "duration_ms"} <= model.model_fields.keys()
        assert (model.__doc__ or "").strip(), f"{kind}: {what} does not say what it does"


def test_the_command_lists_the_faults_of_all_kinds() -> None:
    listed = json.loads(CliRunner().invoke(app, ["fault", "--kinds", "--json"]).output)
    assert listed.keys() == {*BUSES, *DEVICES}
    for kind in BUSES:
        assert list(listed[kind]) == list(found(kind).fault_models)
    assert all("power_off" in listed[kind] for kind in DEVICES)
    assert "delay_ms=" in listed["modbus.tcp"]["delay"]


def test_the_command_lists_the_faults_of_one_kind() -> None:
    output = CliRunner().invoke(app, ["fault", "--kinds", "canopen.node"]).output
    assert "power_off" in output
    wrong = CliRunner().invoke(app, ["fault", "--kinds", "canopen.nod"])
    assert wrong.exit_code == 2
    assert "canopen.node" in wrong.output
