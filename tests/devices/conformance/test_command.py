"""`fieldrig conform` on rigs in virtual time."""

import json
from pathlib import Path
from typing import Any

import pytest
from canopen_bench import EDS
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.errors import BusError, UsageError
from fieldrig.system.exits import Exit
from fieldrig_devices.canopen.described import nodes_of
from fieldrig_devices.hmiscu.settings import HmiscuSettings

LAB = EDS.parent / "lab.yaml"


def conform(*arguments: object) -> Any:
    return CliRunner().invoke(app, ["conform", *map(str, arguments)])


@pytest.mark.long
def test_node_of_a_rig_file_passes_with_the_eds_and_values_that_the_file_names() -> None:
    done = conform("--rig", LAB, "--set", "time=virtual", "--bus", "can0", "--node", 5, "--json")
    assert done.exit_code == Exit.OK, done.output
    report = json.loads(done.stdout)
    assert (report["failed"], report["eds"]) == (0, "io32.eds")
    assert report["passed"] >= 115


@pytest.mark.long
@pytest.mark.parametrize(
    ("rig", "bus", "node", "eds"),
    [
        ("feeder", "can3", 21, "hmiscu.eds"), ("smart-io", "can4", 31, "smart_io.eds"),
        ("conveyor", "can0", 1, "max4-axes.eds"), ("arp-cell", "can0", 20, "terminal.eds"),
    ],
)  # fmt: skip
def test_a_device_with_an_eds_of_its_own_needs_no_option(rig: str, bus: str, node: int, eds: str) -> None:
    file = LAB.with_name(f"{rig}.yaml")
    only = "OD 09" if rig == "feeder" else "SDO 01"  # its program sets objects, and refuses to have them written
    done = conform("--rig", file, "--set", "time=virtual", "--bus", bus, "--node", node, "--only", only, "--json")
    assert done.exit_code == Exit.OK, done.output
    report = json.loads(done.stdout)
    assert (report["eds"], report["passed"]) == (eds, 1)
    assert ("note: line is the master of node 20" in done.stderr) is (node == 20)


def test_an_eds_of_the_settings_of_a_slave_wins(tmp_path: Path) -> None:
    node = {"node_id": 5, "eds": str(EDS / "io32.eds"), "points": {}, "objects": {"1017:00": 500}}
    settings = HmiscuSettings.model_validate({"can_slave": node})
    [described] = nodes_of(settings)
    assert described[:3] == (5, EDS / "io32.eds", {"1017:00": 500})
    assert list(nodes_of(HmiscuSettings())) == []


def test_failure_is_told_by_the_exit_code(tmp_path: Path) -> None:
    eds = tmp_path / "other.eds"
    eds.write_text((EDS / "io32.eds").read_text().replace("DefaultValue=0x000F0191", "DefaultValue=0x00000191"))
    done = conform(
        "--rig", LAB, "--set", "time=virtual", "--bus", "can0", "--node", 5, "--eds", eds, "--only", "SDO 01"
    )
    assert done.exit_code == Exit.NOT_CONFORMING
    assert "expected  91 01 00 00, as in the EDS" in done.stdout


def test_reports_are_written(tmp_path: Path) -> None:
    files = {kind: tmp_path / f"out.{kind}" for kind in ("junit", "html", "markdown")}
    options = [word for kind, path in files.items() for word in (f"--{kind}", path)]
    done = conform("--rig", LAB, "--set", "time=virtual", "--bus", "can0", "--node", 6, "--only", "State", *options)
    assert done.exit_code == Exit.OK, done.output
    assert all("State 01" in path.read_text() for path in files.values())


def test_cases_are_listed_without_a_node() -> None:
    done = conform("--list", "--only", "Transition", "--json")
    assert [case["number"] for case in json.loads(done.stdout)] == ["10.1", "10.2", "10.3", "10.4"]


def test_what_is_missing_is_named(tmp_path: Path) -> None:
    assert "--bus and --node" in conform().output
    assert "--eds FILE" in conform("--bus", "can.udp", "--node", 5).output
    for arguments, what in (
        (("--rig", LAB, "--bus", "can7", "--node", 5), "has no bus 'can7'"),
        (("--rig", LAB, "--bus", "can0", "--node", 9), "has node-ID 9"),
        (("--bus", "can.udp", "--node", 5, "--eds", tmp_path / "no.eds"), "cannot be used as an EDS"),
        (("--only", "SDO 99"), "no case matches"),
    ):
        fault = conform(*arguments).exception
        assert isinstance(fault, UsageError)
        assert what in fault.what


def test_help_lists_the_installed_command() -> None:
    done = CliRunner().invoke(app, ["--help"])
    assert "conform  " in done.output


@pytest.mark.parametrize("text", ["no sections at all", "[DeviceInfo]\n[2000]\nDataType=x\n"])
def test_file_that_is_no_eds_is_named(tmp_path: Path, text: str) -> None:
    eds = tmp_path / "wrong.eds"
    eds.write_text(text)
    fault = conform("--rig", LAB, "--set", "time=virtual", "--bus", "can0", "--node", 5, "--eds", eds).exception
    assert isinstance(fault, UsageError)
    assert "cannot be used as an EDS" in fault.what


def test_the_only_node_of_a_rig_needs_no_name() -> None:
    drive = LAB.with_name("drive.yaml")
    done = conform("--rig", drive, "--set", "time=virtual", "--only", "SDO 01", "--json")
    assert done.exit_code == Exit.OK, done.output
    assert json.loads(done.stdout)["node_id"] == 3


@pytest.mark.parametrize(
    ("given", "what", "expected"),
    [
        ((), "lab has several CANopen nodes", "--bus can0 --node 5 (io), --bus can0 --node 6 (sensor)"),
        (("--bus", "can0"), "lab has several CANopen nodes", "--bus can0 --node 5 (io), --bus can0 --node 6 (sensor)"),
        (("--bus", "wires"), "lab has no such CANopen node", "--bus can0 --node 5 (io), --bus can0 --node 6 (sensor)"),
        (("--node", 7), "lab has no such CANopen node", "--bus can0 --node 5 (io), --bus can0 --node 6 (sensor)"),
    ],
)
def test_which_node_is_meant_is_asked_with_the_choices(given: tuple[object, ...], what: str, expected: str) -> None:
    done = conform("--rig", LAB, "--set", "time=virtual", *given)
    assert isinstance(done.exception, UsageError)
    assert (done.exception.what, done.exception.remedy) == (what, f"expected one of {expected}")


def test_a_rig_without_a_node_says_what_to_name() -> None:
    done = conform("--rig", LAB.with_name("energy-meter.yaml"))
    assert isinstance(done.exception, UsageError)
    assert done.exception.what == "energy-meter has no CANopen node of its own"
    assert done.exception.remedy == "name --bus, --node and --eds FILE"


def test_a_rig_that_does_not_run_is_named_with_what_to_do(tmp_path: Path) -> None:
    done = conform("--rig", LAB, "--set", f"run={tmp_path}", "--node", 5)
    assert isinstance(done.exception, BusError)
    assert done.exception.what.startswith("lab does not run here: can0: no hub answers: no socket ")
    assert done.exception.remedy == "start it by `fieldrig up`, or test the node in virtual time by --set time=virtual"
