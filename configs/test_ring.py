"""The flow wrapper in virtual time: the ring comes up, and the controller enables and moves a drive."""

from pathlib import Path

from fieldrig import RigMaker, S

RIG = Path(__file__).with_name("ring.yaml")
UNDER_CONTROL = 3


def test_the_ring_comes_up_and_a_drive_is_enabled(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.until(lambda: rig.get("max4/booted"), within=60 * S)
    rig.run_for(2 * S)
    assert (rig.get("max4/ring.state"), rig.get("max4/DiagCode")) == ("up", 0)
    rig.set("max4/infeed.ControllerEnable", True)
    rig.run_for(S)
    assert rig.get("max4/infeed.AxisState") == UNDER_CONTROL
    assert rig.get("infeed/torque_on")


def test_the_emergency_stop_takes_the_torque_away(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.until(lambda: rig.get("max4/booted"), within=60 * S)
    rig.run_for(2 * S)
    rig.set("max4/film.ControllerEnable", True)
    rig.run_for(S)
    rig.set("panel/6200:01", 0)
    rig.run_for(S)
    assert not rig.get("film/torque_on")
