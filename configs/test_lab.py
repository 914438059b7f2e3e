"""The lab in virtual time: the drive pumps, the tank fills, and the CANopen nodes see it."""

from pathlib import Path

import pytest

from fieldrig import MS, RigMaker, S
from fieldrig_bus.can import CanFrame

RIG = Path(__file__).with_name("lab.yaml")
START_ALL_NODES = CanFrame(0x000, bytes.fromhex("01 00"))
SENSOR_TPDO1 = 0x186


def test_the_pump_raises_the_level_by_4_mm_a_second(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.set("drive/speed_set", 100)
    rig.set("drive/run", True)
    rig.run_until(100 * S)
    assert rig.get("tank/level") == pytest.approx(0.5 + 100 * 0.001 / 0.25)
    assert rig.get("io/6401:01") == 9000  # 0.1 mm a digit


def test_the_level_transmitter_reports_once_it_is_started(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    heard: list[CanFrame] = []
    can = rig.attach("master").link("can0")
    can.on_receive(heard.append, interest=[(SENSOR_TPDO1, 0x7FF)])
    rig.run_until(100 * MS)
    can.send(START_ALL_NODES)
    rig.run_until(1 * S)
    assert heard[0].data == bytes.fromhex("f4 01 00 00 00")  # 500 mm; its status is good
