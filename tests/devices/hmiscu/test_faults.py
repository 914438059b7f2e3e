"""The faults of a controller: what the blocks report, and how the controller goes on."""

from pathlib import Path

import pytest
from hmiscu_device_bench import PTO, DeviceBench

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig

INTERNAL_ERROR = 1 << 4


def running() -> DeviceBench:
    """A controller whose axis runs at 10 kHz, with a fast stop of 100 ms from 50 kHz."""
    bench = DeviceBench(channel_0=PTO)
    for pin, value in (("Velocity", 10_000), ("Acceleration", 100), ("Deceleration", 100), ("Execute", True)):
        bench.set(f"MoveVelocity.{pin}", value)
    bench.run(500)
    assert bench.get("MoveVelocity.InVelocity")
    return bench


def reset(bench: DeviceBench) -> None:
    bench.set("MoveVelocity.Execute", False)
    bench.set("PTO00.ResetError", True)
    bench.run(20)
    bench.set("PTO00.ResetError", False)
    bench.run(20)


def moves_again(bench: DeviceBench) -> bool:
    bench.set("MoveVelocity.Execute", True)
    bench.run(500)
    return bool(bench.get("MoveVelocity.InVelocity"))


@pytest.mark.long
@pytest.mark.manual("SCU-060", "SCU-065")
def test_a_broken_link_is_a_communication_error_of_every_block() -> None:
    bench = running()
    number = bench.device.add_fault({"what": "link_broken"})
    bench.run(10)
    assert (bench.get("MoveVelocity.ErrID"), bench.get("PTO00.PTOError")) == (4, True)
    bench.run(100)
    assert (bench.get("PTO00.State"), bench.get("PTO00.Frequency")) == (4, 0)
    reset(bench)
    assert (bench.get("PTO00.State"), bench.get("PTO00.ResetProblem")) == (4, "the connection to the outputs is broken")
    bench.device.clear_fault(number)
    assert bench.get("PTO00.State") == 4
    reset(bench)
    assert moves_again(bench)


@pytest.mark.long
@pytest.mark.manual("SCU-062")
def test_an_internal_error_is_bit_4_of_the_diagnosis() -> None:
    bench = running()
    bench.device.add_fault({"what": "internal_error", "duration_ms": 50})
    bench.set("GetDiag.Execute", True)
    bench.run(100)
    assert (bench.get("MoveVelocity.ErrID"), bench.get("GetDiag.PTODiag")) == (5, INTERNAL_ERROR)
    reset(bench)
    assert moves_again(bench)


@pytest.mark.long
@pytest.mark.manual("SCU-018")
@pytest.mark.parametrize("what", ["offline", "exit_runtime"])
def test_a_panel_that_leaves_its_runtime_stops_the_axis_fast(what: str) -> None:
    bench = running()
    position = int(bench.get("PTO00.Position"))
    number = bench.device.add_fault({"what": what})
    assert bench.get("plc/state") == "stop"
    bench.run(100)
    # 100 ms from 50 kHz: 10 kHz in 20 ms, so 100 pulses
    assert abs(int(bench.get("PTO00.Position")) - position - 100) <= 3
    with pytest.raises(ValueError, match=what):
        bench.set("plc/command", "run")
    bench.device.clear_fault(number)
    bench.run(100)
    assert bench.get("plc/state") == "run"
    if what == "exit_runtime":
        assert (bench.get("PTO00.State"), bench.get("MoveVelocity.Velocity")) == (0, 0)
        return
    assert bench.get("PTO00.State") == 4
    reset(bench)
    assert moves_again(bench)


@pytest.mark.parametrize("what", ["offline", "exit_runtime"])
@pytest.mark.parametrize("is_restarted", [False, True])
def test_a_controller_that_starts_during_the_fault_runs_at_its_end(what: str, is_restarted: bool) -> None:
    rig = {
        "time": "virtual",
        "buses": {"modbus": {"kind": "modbus.virtual"}, "wires": {"kind": "wires.virtual"}},
        "devices": {"plc": {"kind": "hmiscu", "model": "HMISCU6A5", "links": {"modbus": "modbus", "wires": "wires"}}},
    }
    fault = {"what": what, "duration_ms": 100}
    if not is_restarted:
        rig["devices"]["plc"]["faults"] = [fault]  # type: ignore[index]  # a mapping of mappings
    with Rig(from_dict(rig, Path.cwd())) as running_rig:
        if is_restarted:
            running_rig.run_until(50 * MS)
            running_rig.add_fault("plc", fault)
            running_rig.restart("plc")
        assert running_rig.get("plc/plc/state") == "stop"
        running_rig.run_for(200 * MS)
        assert running_rig.get("plc/plc/state") == "run"


def test_a_stopped_controller_stays_stopped_after_the_fault() -> None:
    bench = DeviceBench(channel_0=PTO)
    bench.set("plc/command", "stop")
    bench.device.add_fault({"what": "offline", "duration_ms": 20})
    bench.run(100)
    assert bench.get("plc/state") == "stop"


@pytest.mark.parametrize("what", ["link_broken", "internal_error"])
def test_a_controller_without_a_pulse_output_takes_the_fault(what: str) -> None:
    bench = DeviceBench()
    bench.device.add_fault({"what": what, "duration_ms": 20})
    bench.run(100)
    assert bench.get("plc/state") == "run"
