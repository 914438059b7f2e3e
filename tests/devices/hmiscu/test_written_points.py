"""A point that a tool or master sets reads so at once, or it is refused with the reason and what to do."""

from pathlib import Path

import pytest
from canopen_bench import EDS
from hmiscu_device_bench import DeviceBench

from fieldrig.clock import S
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig

PROGRAM = """
VAR_GLOBAL g_bWrite : BOOL := TRUE; END_VAR
PROGRAM PLC_PRG
IF g_bWrite THEN PanelText(Line := 1, Text := 'ready'); END_IF
END_PROGRAM
"""
OUTPUTS = ["DQ3", "FQ1", "panel.lamp2"]


@pytest.mark.parametrize("has_program", [False, True])
@pytest.mark.parametrize("name", OUTPUTS)
def test_an_output_that_is_set_reads_so_at_once_and_later(tmp_path: Path, name: str, has_program: bool) -> None:
    """It read its old value until the next cycle, which `fieldrig set` printed."""
    bench = DeviceBench(tmp_path, PROGRAM) if has_program else DeviceBench()
    bench.run(50)
    for level in (True, False, True):
        bench.set(name, level)
        assert bench.get(name) is level
        bench.run(50)
        assert bench.get(name) is level


@pytest.mark.parametrize("name", OUTPUTS)
def test_an_output_of_a_controller_that_is_not_in_run_is_not_set(tmp_path: Path, name: str) -> None:
    bench = DeviceBench(tmp_path, PROGRAM)
    bench.run(50)
    bench.set("plc/command", "stop")
    bench.run(50)
    with pytest.raises(ValueError, match="does not change while the controller is not in RUN\nexpected plc/command"):
        bench.set(name, True)
    bench.set("plc/command", "run")
    bench.run(50)
    bench.set(name, True)
    assert bench.get(name) is True


def test_a_line_that_the_program_writes_is_not_set_from_outside(tmp_path: Path) -> None:
    bench = DeviceBench(tmp_path, PROGRAM)
    bench.run(50)
    with pytest.raises(ValueError, match=r"the program writes panel\.line1"):
        bench.set("panel.line1", "hello")
    bench.set("panel.line2", "hello")
    bench.set("g_bWrite", False)
    bench.run(500)
    bench.set("panel.line1", "hello")
    bench.run(500)
    assert (bench.get("panel.line1"), bench.get("panel.line2")) == ("hello", "hello")


def test_a_master_sets_a_lamp_that_no_program_drives() -> None:
    """The controller has not started while a rig file is checked, so nothing is said there of outputs in STOP."""
    io = {"kind": "canopen.node", "node_id": 5, "eds": str(EDS / "io32.eds"), "links": {"can": "can0"}}
    inputs = {1: [{"name": "panel.lamp1", "type": "bool"}]}
    scu = {
        "kind": "hmiscu",
        "links": {"can": "can0"},
        "can_master": {"nodes": {"Io": {"node_id": 5, "inputs": inputs}}},
    }
    buses = {"can0": {"kind": "can.virtual"}}
    with Rig(from_dict({"time": "virtual", "buses": buses, "devices": {"scu": scu, "io": io}})) as rig:
        rig.run_for(2 * S)
        assert rig.get("scu/panel.lamp1") is False
        rig.set("io/6000:01", 1)
        rig.run_for(1 * S)
        assert rig.get("scu/panel.lamp1") is True
