"""Which devices share a process: the key `processes`, and what a part of a rig loads."""

from pathlib import Path
from typing import Any

import pytest

from fieldrig.config.rig_file import from_dict, load, load_part
from fieldrig.errors import ConfigError
from fieldrig.real.placement import placement

HERE = Path(__file__).parents[1]
ROOT = HERE.parents[1]
RIGS = ("configs/lab.yaml", "configs/ring.yaml", "configs/pam-machine.yaml", "docker/machine.yaml")
BUSES = {"w": {"kind": "wires.hub"}, "v": {"kind": "wires.hub"}}
DEVICES = {
    "axis1": {"kind": "rig_kinds:Adder", "links": {"wires": "w"}},
    "axis2": {"kind": "rig_kinds:Adder", "links": {"wires": "w"}},
    "desk": {"kind": "rig_kinds:Adder", "links": {"wires": "w"}, "process": "table"},
    "lamp": {"kind": "rig_kinds:Adder", "links": {"wires": "v"}},
}


def homes_by(processes: Any, time: str = "real") -> dict[str, str]:
    buses = {name: {"kind": "wires.virtual" if time == "virtual" else "wires.hub"} for name in BUSES}
    config = from_dict({"time": time, "processes": processes, "buses": buses, "devices": DEVICES}, HERE)
    return {name: entry.process for name, entry in config.devices.items()}


@pytest.mark.parametrize(
    ("processes", "homes"),
    [
        ({}, ("axis1", "axis2", "table", "lamp")),
        ({"all": "w"}, ("all", "all", "table", "lamp")),
        ({"rack": "axis*"}, ("rack", "rack", "table", "lamp")),
        ({"rack": "axis[2-9]"}, ("axis1", "rack", "table", "lamp")),
        ({"rack": ["axis1", "v"]}, ("rack", "axis2", "table", "rack")),
        ({"axis1": "axis1", "rest": "w"}, ("axis1", "rest", "table", "lamp")),
        ({"all": "*"}, ("all", "all", "table", "all")),
    ],
)
def test_one_line_puts_the_devices_of_a_bus_or_a_pattern_into_a_process(processes: Any, homes: tuple[str, ...]) -> None:
    """A device that names its process keeps it, and of two lines the first one counts."""
    assert tuple(homes_by(processes).values()) == homes


def test_a_bus_whose_devices_were_put_into_one_process_runs_there_too() -> None:
    plans = placement(from_dict({"time": "real", "processes": {"all": "*"}, "buses": BUSES, "devices": DEVICES}, HERE))
    assert (plans["all"].buses, plans["all"].devices) == (("v",), ("axis1", "axis2", "lamp"))


@pytest.mark.parametrize(
    ("processes", "said"),
    [
        ({"all": "axes*"}, 'processes.all: no device is on a bus "axes*" or has a name like it\ndid you mean axis'),
        ({"all": ["w", "lmap"]}, "did you mean lamp?"),
        ("each", "processes: each has no meaning with time: real\nname the processes and their devices"),
        ({"all": 3}, "processes.all: 3 doesn't fit"),
        ({"Not A Name": "w"}, "processes"),
        (["w"], "processes"),
    ],
)
def test_a_line_that_no_device_matches_is_refused(processes: Any, said: str) -> None:
    with pytest.raises(ConfigError) as refused:
        homes_by(processes)
    shown = "\n".join(line.strip() for line in str(refused.value).splitlines())
    assert said in shown


def test_in_virtual_time_the_processes_of_an_extended_rig_are_left_alone() -> None:
    assert homes_by({"all": "w"}, time="virtual")["axis1"] == "all"


@pytest.mark.long
@pytest.mark.parametrize("file", RIGS)
def test_a_part_runs_what_it_runs_in_the_whole_rig(file: str) -> None:
    config = load(ROOT / file)
    for plan in placement(config).values():
        for name in dict.fromkeys((plan.name, *plan.buses, *plan.devices)):
            part = load_part(ROOT / file, (), name)
            found = placement(part)[plan.name]
            assert (found.buses, found.devices) == (plan.buses, plan.devices), name
            assert all(part.buses[bus].members == config.buses[bus].members for bus in part.buses)
