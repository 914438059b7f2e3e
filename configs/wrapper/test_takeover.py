"""Another master takes an axis of the flow wrapper over: pytest, or `fieldrig iec test` with this file."""

from typing import Any

from fieldrig import MS, S
from fieldrig_bus.can import CanFrame
from fieldrig_bus.wires import Signal

MANUAL, RUNNING = 0, 3
INFEED = 1
"""The node of the controller's axes; the objects of the infeed begin at 6000h."""


def write(can: Any, index: int, value: int, size: int) -> None:
    """Write an object by an expedited SDO (CiA 301 7.2.4.3.3)."""
    command = 0x23 | (4 - size) << 2
    data = bytes((command, index & 0xFF, index >> 8, 0)) + value.to_bytes(4, "little", signed=True)
    can.send(CanFrame(0x600 + INFEED, data))


def start(rig: Any, wires: Any, after_ns: int) -> None:
    """Give the machine what it waits for, and let it run some time after that."""
    rig.set("panel/6200:01", 1)
    wires.send(Signal("nip.reference", 0.553))
    wires.send(Signal("tower.green", 1))
    rig.run_for(after_ns)
    rig.set("max4/g_bAutomatic", True)


def test_an_axis_that_another_master_takes_over_stops_the_others(fieldrig_rig: Any) -> None:
    rig = fieldrig_rig("configs/wrapper/wrapper.yaml")
    master = rig.attach("other master")
    wires, can = master.link("wires"), master.link("can0")
    rig.run_until(4 * S)
    start(rig, wires, 1 * S)
    rig.until(lambda: rig.get("max4/g_iState") == RUNNING, within=3 * S)
    rig.run_for(1 * S)
    write(can, 0x6060, 3, 1)  # profile velocity
    write(can, 0x60FF, 1_000_000, 4)
    for control in (0x06, 0x07, 0x0F):
        write(can, 0x6040, control, 2)
        rig.run_for(20 * MS)
    rig.until(lambda: rig.get("max4/g_wFailures") == 1, within=200 * MS)
    rig.until(lambda: rig.get("max4/g_iState") == MANUAL, within=3 * S)
    assert all(abs(rig.get(f"{axis}/speed")) < 1 for axis in ("film", "jaw", "outfeed"))
    assert rig.get("infeed/speed") > 50


def test_a_pack_that_the_ring_ends_after_the_stop_is_not_counted(fieldrig_rig: Any) -> None:
    """A search has found it: with the stop the program forgot to look whether an axis was lost in the last pack."""
    rig = fieldrig_rig("configs/wrapper/wrapper.yaml")
    wires = rig.attach("cell").link("wires")
    rig.run_until(5 * S)
    start(rig, wires, 500 * MS)
    rig.run_for(200 * MS)
    wires.send(Signal("tower.green", 0))
    rig.run_for(100 * MS)
    rig.add_fault("ring", {"what": "break", "after": "infeed", "duration_ms": 1})
    rig.run_for(500 * MS)
    assert rig.get("max4/g_iState") == MANUAL
    assert rig.get("max4/g_dwPacks") == 0
