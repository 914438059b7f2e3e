"""The drive of drive.yaml in virtual time: a master homes it, and moves a belt with it, by SDO."""

from pathlib import Path

from fieldrig import MS, Rig, RigMaker, S
from fieldrig_bus.can import CanFrame

RIG = Path(__file__).with_name("drive.yaml")
START_NODE_3 = CanFrame(0x000, bytes.fromhex("01 03"))
PROFILE_POSITION, HOMING = 1, 6


class Master:
    """Writes objects of node 3 by SDO, with the head of an expedited download in hex."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.can = rig.attach("master").link("can0")
        rig.run_for(100 * MS)
        self.can.send(START_NODE_3)

    def write(self, head: str, value: int) -> None:
        self.can.send(CanFrame(0x603, bytes.fromhex(head) + value.to_bytes(4, "little", signed=value < 0)))
        self.rig.run_for(5 * MS)

    def control(self, *words: int) -> None:
        for word in words:
            self.write("2b 40 60 00", word)
            self.rig.run_for(60 * MS)  # the brake takes 40 ms

    def enable(self, mode: int) -> None:
        self.write("2f 60 60 00", mode)
        self.control(0x06, 0x07, 0x0F)
        assert self.rig.get("axis/state") == "operation enabled"


def test_it_homes_at_its_switch(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    master = Master(rig)
    master.write("2f 98 60 00", 19)  # method 19: onto the home switch, and back to its edge
    master.enable(HOMING)
    master.control(0x1F)
    rig.until(lambda: int(rig.get("axis/status_word")) & 0x1400 == 0x1400, within=30 * S)
    assert abs(float(rig.get("axis/position")) - 0.5) < 0.01


def test_a_move_brings_products_to_the_end(fieldrig_rig: RigMaker) -> None:
    """50 turns of the motor are 5 of the roller: 1.57 m of belt."""
    rig = fieldrig_rig(RIG)
    master = Master(rig)
    master.enable(PROFILE_POSITION)
    master.write("23 81 60 00", 20_000_000)
    master.write("23 83 60 00", 100_000_000)
    master.write("23 84 60 00", 100_000_000)
    master.write("23 7a 60 00", 50_000_000)
    master.control(0x1F)
    rig.until(lambda: int(rig.get("axis/status_word")) & 0x0400, within=30 * S)
    assert abs(float(rig.get("belt/position")) - 10 * 3.14159265 * 0.05) < 0.001
    assert int(rig.get("belt/discharged")) >= 2


def test_a_master_that_stops_the_node_sees_a_fault(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    master = Master(rig)
    master.enable(PROFILE_POSITION)
    master.can.send(CanFrame(0x000, bytes.fromhex("02 03")))
    rig.run_for(500 * MS)
    assert (rig.get("axis/state"), rig.get("axis/error_code")) == ("fault", 0x8130)
