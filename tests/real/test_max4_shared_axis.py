"""A program of a MAx-4, python canopen and pymodbus share one axis: the one that moved it last controls it."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from struct import Struct
from typing import Any

import canopen
import pytest
from canopen_network import network_on, socketcand_at
from pymodbus.client import ModbusTcpClient
from running_rig import RunningRig, until

from fieldrig.testing import free_port

pytestmark = [pytest.mark.real, pytest.mark.timeout(400)]

RIG = """
time: real
buses:
  tcp: {{kind: modbus.tcp, listen: "127.0.0.1:{modbus}"}}
  can0: {{kind: can.hub, bitrate: 1000000, socketcand: "127.0.0.1:{can}"}}
devices:
  max4:
    kind: max4
    links: {{modbus: tcp, can: can0}}
    drives: {{belt: {{ring_address: 1, simulated: true}}}}
    can_axes: {{node_ids: [{node}]}}
    logic_encoders: [Master]
    program: {program}
    autostart: true
"""
PROGRAM = """
PROGRAM PLC_PRG
VAR
  bWanted AT %MX0.0 : BOOL;
  iState AT %MW2 : INT;
  fbCam : CAM;
  lStraight : DINT;
END_VAR
CASE iState OF
0: lStraight := ProfilLoad('straight'); iState := 1;
1: IF bWanted THEN
     ControllerEnableSet(_belt);
     IF belt.AxisState = 3 THEN iState := 2; END_IF
   END_IF
2: fbCam(lAxisId := _belt, lEncId := _Master, lProfilId := lStraight, bReset := TRUE);
   IF fbCam.lResult = 0 THEN Master.Velocity := 100000.0; iState := 3; END_IF
3: fbCam(bReset := FALSE);
   IF fbCam.bDone THEN iState := 4; END_IF  (* another master has the axis *)
4: IF NOT bWanted THEN iState := 1; END_IF
END_CASE
END_PROGRAM
"""
NODE = 5
MARKERS = 0x8000
TARGET, SPEED, COMMAND, START = 1002, 1004, 1013, 1
MOVES, IS_TAKEN = 3, 4
BYTE, WORD, LONG = Struct("<b"), Struct("<H"), Struct("<i")


class Masters:
    def __init__(self, modbus: ModbusTcpClient, node: Any, rig: RunningRig) -> None:
        self.modbus, self._node, self.rig = modbus, node, rig

    def get(self, index: int, form: Struct) -> int:
        (value,) = form.unpack(self._node.sdo.upload(index, 0))
        return int(value)

    def put(self, index: int, form: Struct, value: int) -> None:
        self._node.sdo.download(index, 0, form.pack(value))

    def speed(self) -> int:
        """The velocity of the axis as the CANopen master sees it, in increments per second."""
        return self.get(0x606C, LONG)

    def want(self, is_on: bool) -> None:
        assert not self.modbus.write_coil(MARKERS, is_on).isError()

    def state(self) -> int:
        """The state of the program."""
        return int(self.modbus.read_holding_registers(MARKERS + 2, count=1).registers[0])

    def start_program(self) -> None:
        self.want(False)
        until(lambda: self.state() == 1)
        self.want(True)
        until(lambda: self.state() == MOVES)
        until(lambda: abs(self.speed() - 100_000) < 2_000)


@contextmanager
def masters(folder: Path) -> Iterator[Masters]:
    modbus, can, program = free_port(), free_port(), folder / "shared.st"
    program.write_text(PROGRAM)
    with RunningRig(RIG.format(modbus=modbus, can=can, node=NODE, program=program), None) as rig:
        rig.until_ready()
        until(lambda: rig.value("max4/booted"))
        with network_on(socketcand_at(can)) as network, ModbusTcpClient("127.0.0.1", port=modbus, timeout=10) as client:
            nothing: Any = canopen.ObjectDictionary()  # type: ignore[no-untyped-call]
            yield Masters(client, network.add_node(NODE, nothing), rig)


def test_a_program_and_two_foreign_masters_take_an_axis_over_from_one_another(tmp_path: Path) -> None:
    with masters(tmp_path) as found:
        found.start_program()
        found.put(0x6060, BYTE, 3)  # the CANopen master: profile velocity
        found.put(0x60FF, LONG, -50_000)
        for control in (6, 7, 15):
            found.put(0x6040, WORD, control)
        until(lambda: found.state() == IS_TAKEN)
        until(lambda: abs(found.speed() + 50_000) < 1_000)
        found.start_program()
        words = [*found.modbus.convert_to_registers(0, found.modbus.DATATYPE.INT32)]  # the Modbus master: to 0
        assert not found.modbus.write_registers(TARGET, words).isError()
        words = found.modbus.convert_to_registers(5_000, found.modbus.DATATYPE.UINT32)
        assert not found.modbus.write_registers(SPEED, words).isError()
        assert not found.modbus.write_registers(COMMAND, [START]).isError()
        until(lambda: found.state() == IS_TAKEN)
        until(lambda: found.rig.value("max4/belt.Position") == 0)
        found.start_program()
