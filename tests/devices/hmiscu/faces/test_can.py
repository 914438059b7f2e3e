"""The controller as a CiA 401 slave: frames on the bus against terminals, pins and counters."""

from pathlib import Path
from typing import Any

import pytest
from hmiscu_device_bench import PTO, DeviceBench
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.system.exits import Exit
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.hmiscu.faces.objects import EDS, eds_text

START = CanFrame(0x000, b"\x01\x05")


@pytest.fixture
def bench() -> DeviceBench:
    bench = DeviceBench(channel_0=PTO, can_slave={"node_id": 5})
    bench.run(105)
    bench.can.deliver(START)
    bench.can.take()
    return bench


def sdo(bench: DeviceBench, request: str) -> str:
    """The response of the SDO server, at once."""
    bench.can.take()
    bench.can.deliver(CanFrame(0x605, bytes.fromhex(request)))
    (frame,) = [frame for frame in bench.can.take() if frame.identifier == 0x585]
    return frame.data.hex()


def test_the_file_is_the_one_that_the_tables_give() -> None:
    assert EDS.read_text() == eds_text()


def test_outputs_follow_the_first_rpdo_and_inputs_send_the_first_tpdo(bench: DeviceBench) -> None:
    bench.can.deliver(CanFrame(0x205, bytes.fromhex("01 00 80")))
    bench.run(10)
    assert (bench.level("lamp"), bench.get("panel.lamp8")) == (True, True)
    bench.can.take()
    bench.wire("drive.ready", True)
    bench.set("panel.key1", True)
    bench.run(10)
    frames = [frame for frame in bench.can.take() if frame.identifier == 0x185]
    assert frames[-1].data == bytes.fromhex("04 00 01")


@pytest.mark.long
def test_outputs_take_their_error_values_when_the_node_is_stopped(bench: DeviceBench) -> None:
    bench.can.deliver(CanFrame(0x205, bytes.fromhex("01 00 00")))
    bench.run(10)
    bench.can.deliver(CanFrame(0x000, b"\x02\x05"))
    bench.run(10)
    assert bench.level("lamp") is False


@pytest.mark.long
def test_a_master_moves_the_axis_by_objects_and_reads_the_counters(bench: DeviceBench) -> None:
    # 2001h MoveRelative: 3 Velocity, 4 Distance, 5 Acceleration, 6 Deceleration, 2 Execute, 9 Done
    for subindex, value in ((3, 20_000), (4, 40_000), (5, 1_000), (6, 500)):
        assert sdo(bench, f"23 01 20 {subindex:02x} {value.to_bytes(4, 'little').hex()}").startswith("600120")
    assert sdo(bench, "2f 01 20 02 01 00 00 00").startswith("600120")
    bench.run(3_000)
    assert sdo(bench, "40 01 20 09 00 00 00 00") == "4f01200901000000"
    assert sdo(bench, "40 10 20 01 00 00 00 00") == "43102001409c0000"  # pulses of the move
    assert sdo(bench, "40 10 20 02 00 00 00 00") == "43102002409c0000"  # position
    assert sdo(bench, "40 10 20 03 00 00 00 00") == "4f10200300000000"  # Standstill


@pytest.mark.long
def test_an_object_of_a_channel_that_is_not_there_takes_a_value_without_effect(bench: DeviceBench) -> None:
    assert sdo(bench, "2f 07 20 06 32 00 00 00") == "6007200600000000"  # PWM00.Duty
    assert bench.device.find("PWM00.Duty") is None


@pytest.mark.long
def test_points_may_be_named_in_the_settings(tmp_path: Path) -> None:
    program = "VAR_GLOBAL g_byCount : BYTE; END_VAR PROGRAM PLC_PRG END_PROGRAM"
    bench = DeviceBench(tmp_path, program, can_slave={"node_id": 5, "points": {"6200:01": "g_byCount"}})
    bench.can.deliver(START)
    bench.can.deliver(CanFrame(0x205, bytes.fromhex("2a 00 00")))
    assert bench.get("g_byCount") == 42
    with pytest.raises(ValueError, match=r"can_slave\.points: expected points of the device, got g_wrong"):
        DeviceBench(tmp_path, program, can_slave={"node_id": 5, "points": {"6200:01": "g_wrong"}})


@pytest.mark.long
def test_the_node_passes_the_conformance_suite(tmp_path: Path) -> None:
    rig = tmp_path / "scu.yaml"
    rig.write_text(
        "time: virtual\nbuses: {can0: {kind: can.virtual}}\n"
        "devices: {scu: {kind: hmiscu, links: {can: can0}, can_slave: {node_id: 5}, channel_0: {mode: pto}}}\n"
    )
    arguments: list[Any] = ["conform", "--rig", rig, "--bus", "can0", "--node", 5, "--eds", EDS]
    done = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert done.exit_code == Exit.OK, done.output
