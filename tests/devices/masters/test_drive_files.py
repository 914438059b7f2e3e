"""python canopen's `BaseNode402` moves the drive of each foreign EDS or DCF file to the end, in every mode it declares.

The files are those of `drive_files`.  The master does what each of them asks of it: it lets its RPDOs take effect at
once where the file makes them synchronous, enables the buffer of set-points by 60C4h, and writes 6060h itself where
there is no 6502h, which it would read first.  It gets a copy of the files that its reader refuses.
"""

import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from drive_files import FILES, path_of

from fieldrig import Rig, from_dict, virtual_time
from fieldrig_devices.cia402.single.foreign import declared

pytestmark = [pytest.mark.lean, pytest.mark.long, pytest.mark.timeout(300)]

NODE = 3
NAMES = {
    1: "PROFILED POSITION", 2: "VELOCITY", 3: "PROFILED VELOCITY", 4: "PROFILED TORQUE", 6: "HOMING",
    7: "INTERPOLATED POSITION", 8: "CYCLIC SYNCHRONOUS POSITION", 9: "CYCLIC SYNCHRONOUS VELOCITY",
    10: "CYCLIC SYNCHRONOUS TORQUE",
}  # fmt: skip
MASTER: Any = BaseNode402
CASES = [(name, mode) for name, facts in FILES.items() for mode in sorted(facts.modes) if mode in NAMES]
WAY, STEPS = 1_000, 100


class Moved:
    """One drive and its master, enabled in a mode."""

    def __init__(self, path: Path, rig: Rig, network: Any, node: Any) -> None:
        self.path, self.rig, self.network, self.node = path, rig, network, node
        self.lead: Any = None
        """The RPDO with the control word, if there is one."""

    def has(self, index: int, subindex: int = 0) -> bool:
        objects = self.node.object_dictionary
        return index in objects and (subindex == 0 or subindex in objects[index])

    def put(self, index: int, value: int, subindex: int = 0) -> None:
        """Write by the RPDO with the control word, if it has the object, and otherwise by SDO."""
        for variable in self.lead.map if self.lead is not None else ():
            if (variable.index, variable.subindex) == (index, subindex):
                variable.raw = value
                self.lead.transmit()
                return
        place = self.node.sdo[index]
        (place[subindex] if subindex else place).raw = value

    @property
    def speed(self) -> float:
        """The speed of the motor in turns per minute."""
        return float(self.rig.get("axis/speed"))

    def get(self, index: int) -> int:
        return int(self.node.sdo[index].raw)

    def set_up(self) -> None:
        node = self.node
        node.nmt.state = "PRE-OPERATIONAL"
        node.setup_402_state_machine()
        for index, pointers in (
            (0x6041, node.tpdo_pointers),
            (0x6060, node.rpdo_pointers),
            (0x6040, node.rpdo_pointers),
        ):
            pdo = pointers[index].pdo_parent if index in pointers else None
            if pdo is not None and pdo.enabled and pdo.trans_type <= (0 if index == 0x6041 else 240):
                pdo.trans_type = 255
                pdo.save()
            self.lead = pdo if pdo is not None and pdo.enabled else None
        node.nmt.state = "OPERATIONAL"
        self.network.sync.start(0.01)
        for variable in self.lead.map if self.lead is not None else ():
            if variable.index in (0x607A, 0x60C1):
                variable.raw = self.get(0x6064)

    def enable(self, mode: int) -> None:
        if self.has(0x6502):
            self.node.op_mode = NAMES[mode]
        else:
            self.node.sdo[0x6060].raw = mode
        self.node.state = "OPERATION ENABLED"
        assert self.node.state == "OPERATION ENABLED"
        if self.has(0x6081) and self.get(0x6081) == 0:
            self.node.sdo[0x6081].raw = 2_000  # a file whose power-on value is standstill

    def close(self) -> None:
        self.network.sync.stop()
        self.network.disconnect()


def readable(path: Path, folder: Path) -> Path:
    """Return a copy that the reader of python canopen takes: UTF-8, and with a type and an access for each domain."""
    content = path.read_bytes()
    try:
        text = content.decode()
    except UnicodeDecodeError:
        text = content.decode("cp1252")
    parts = re.split(r"(?m)^(?=\[)", text.replace("\r\n", "\n"))
    whole = [
        f"{part.rstrip()}\nDataType=0x000F\nAccessType=ro\n\n"
        if "ObjectType=0x2\n" in part and "DataType" not in part
        else part
        for part in parts
    ]
    copy = folder / path.name
    copy.write_text("".join(whole), "utf-8")
    return copy


@contextmanager
def moved(path: Path, folder: Path) -> Iterator[Moved]:
    drive = {"kind": "cia402.drive", "node_id": NODE, "eds": str(path), "links": {"can": "can0"}}
    home = {"switches": {"home": {"low": 3.0, "high": 1e6}}}
    buses = {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}}
    config = from_dict({"time": "virtual", "buses": buses, "devices": {"axis": {**drive, **home}}})
    with Rig(config) as rig, virtual_time(rig, limit_s=600):
        network: Any = canopen.Network()
        network.connect(interface="fieldrig", channel="can0")
        node = MASTER(NODE, str(readable(path, folder)))
        network.add_node(node)
        time.sleep(1)
        bench = Moved(path, rig, network, node)
        bench.set_up()
        yield bench
        bench.close()


def to_a_target(bench: Moved) -> None:
    begin = bench.get(0x6064)
    bench.put(0x607A, begin + WAY)
    bench.node.controlword = 0x0F
    time.sleep(0.05)
    bench.node.controlword = 0x1F
    time.sleep(15)
    assert bench.get(0x6064) == pytest.approx(begin + WAY, abs=2)
    assert bench.node.statusword & 0x0400


def at_a_speed_of_an_inverter(bench: Moved) -> None:
    target = 20_000  # one file has 6000 units per turn and minute; others are held at their own limits
    bench.put(0x6042, target)
    bench.node.controlword = 0x7F
    time.sleep(20)
    assert bench.get(0x6044) == pytest.approx(bench.get(0x6043), rel=0.03)
    assert bench.speed > 1


def at_a_speed(bench: Moved) -> None:
    most = [bench.get(index) for index in (0x607F, 0x6080) if bench.has(index)]
    target = min([100, *(limit for limit in most if limit)]) * 9 // 10
    bench.put(0x60FF, target)
    time.sleep(8)
    assert bench.get(0x606C) == pytest.approx(target, abs=max(3, target // 50))


def by_a_torque(bench: Moved) -> None:
    bench.put(0x6071, 100)
    time.sleep(3)
    assert bench.speed > 5


def home(bench: Moved) -> None:
    methods = declared(bench.path).behaviour.homing_methods or ()
    bench.put(0x6098, next(method for method in (19, 35, 37, 1) if method in methods))
    bench.node.controlword = 0x1F
    end_s = time.monotonic() + 500
    while bench.get(0x6041) & 0x3400 != 0x1400:  # attained, and no error
        assert time.monotonic() < end_s, f"the status word is {bench.get(0x6041):#x}"
        time.sleep(1)


def by_positions(bench: Moved, index: int, subindex: int = 0) -> None:
    begin = bench.get(0x6064)
    for step in range(1, STEPS + 1):
        bench.put(index, begin + step * WAY // STEPS, subindex)
        time.sleep(0.01)
    time.sleep(10)
    assert bench.get(0x6064) == pytest.approx(begin + WAY, abs=2)


def by_interpolation(bench: Moved) -> None:
    if bench.has(0x60C4, 6):
        bench.node.sdo[0x60C4][6].raw = 1
    if bench.has(0x60C2, 1):
        bench.node.sdo[0x60C2][1].raw = 10
        if bench.node.sdo[0x60C2][2].raw != -3:
            bench.node.sdo[0x60C2][2].raw = -3
    bench.node.controlword = 0x1F
    by_positions(bench, 0x60C1, 1 if bench.has(0x60C1, 1) else 0)


HOW = {
    1: to_a_target, 2: at_a_speed_of_an_inverter, 3: at_a_speed, 4: by_a_torque, 6: home, 7: by_interpolation,
    8: lambda bench: by_positions(bench, 0x607A), 9: at_a_speed, 10: by_a_torque,
}  # fmt: skip


@pytest.mark.parametrize(("name", "mode"), CASES)
def test_a_master_moves_the_drive_of_a_file_to_the_end(name: str, mode: int, tmp_path: Path) -> None:
    path = path_of(name)
    assert mode in (declared(path).behaviour.modes or ())
    with moved(path, tmp_path) as bench:
        bench.enable(mode)
        HOW[mode](bench)
