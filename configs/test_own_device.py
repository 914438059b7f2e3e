"""The press in virtual time: it closes on command, and reports it on CAN."""

from pathlib import Path

from fieldrig import MS, RigMaker
from fieldrig_bus.can import CanFrame

RIG = Path(__file__).with_name("own-device.yaml")
VIRTUAL = ("time=virtual", "buses.can0={kind: can.virtual}", "buses.wires={kind: wires.virtual}")
CLOSE = CanFrame(0x201, bytes.fromhex("01"))


def test_the_press_closes_within_its_time(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG, *VIRTUAL)
    host = rig.attach("host").link("can0")
    heard: list[CanFrame] = []
    host.on_receive(heard.append)
    host.send(CLOSE)
    rig.run_until(2150 * MS)  # 120 mm at 60 mm/s
    assert rig.get("press/state") == "CLOSED"
    assert heard[-1] == CanFrame(0x181, bytes.fromhex("02 b0 04"))  # closed, 120.0 mm
