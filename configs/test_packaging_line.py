"""The line of forty drives in virtual time: the ring comes up, and a drive of each rack is enabled."""

from pathlib import Path

from fieldrig import RigMaker, S

RIG = Path(__file__).with_name("packaging-line.yaml")
ONE_OF_EACH_RACK = ("in1", "jaw2", "press", "stretch")
UNDER_CONTROL = 3


def test_the_ring_comes_up_and_a_drive_of_each_rack_is_enabled(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.until(lambda: rig.get("max4/booted"), within=60 * S)
    rig.run_for(2 * S)
    assert (rig.get("max4/ring.state"), rig.get("max4/DiagCode")) == ("up", 0)
    for name in ONE_OF_EACH_RACK:
        rig.set("max4", f"{name}.ControllerEnable", True)
    rig.run_for(S)
    assert [rig.get("max4", f"{name}.AxisState") for name in ONE_OF_EACH_RACK] == [UNDER_CONTROL] * 4
