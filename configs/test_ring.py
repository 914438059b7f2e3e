"""The flow wrapper in virtual time: the ring comes up, and the controller enables and moves a drive."""

from pathlib import Path

from fieldrig.clock import S
from fieldrig.pytest_plugin import RigMaker

RIG = Path(__file__).with_name("ring-virtual.yaml")
UNDER_CONTROL = 3


def test_the_ring_comes_up_and_a_drive_is_enabled(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    while not rig.get("max4", "booted"):
        rig.run_until(rig.now_ns + S)
    rig.run_until(rig.now_ns + 2 * S)
    assert (rig.get("max4", "ring.state"), rig.get("max4", "DiagCode")) == ("up", 0)
    rig.set("max4", "infeed.ControllerEnable", True)
    rig.run_until(rig.now_ns + S)
    assert rig.get("max4", "infeed.AxisState") == UNDER_CONTROL
    assert rig.get("infeed", "torque_on")


def test_the_emergency_stop_takes_the_torque_away(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    while not rig.get("max4", "booted"):
        rig.run_until(rig.now_ns + S)
    rig.run_until(rig.now_ns + 2 * S)
    rig.set("max4", "film.ControllerEnable", True)
    rig.run_until(rig.now_ns + S)
    rig.set("panel", "6200:01", 0)
    rig.run_until(rig.now_ns + S)
    assert not rig.get("film", "torque_on")
