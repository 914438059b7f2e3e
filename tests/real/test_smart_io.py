"""Foreign masters of a running Smart-IO without a PAM: python canopen by its EDS file, and pymodbus."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest
from canopen_network import network_on, socketcand_at
from pymodbus.client import ModbusTcpClient
from running_rig import RunningRig, until

from fieldrig.testing import free_port
from fieldrig_devices.smart_io.faces.objects import EDS

pytestmark = pytest.mark.real

RIG = """
time: real
buses:
  can0: {{kind: can.hub, process: rig, bitrate: 500000, socketcand: "127.0.0.1:{can}"}}
  tcp: {{kind: modbus.tcp, listen: "127.0.0.1:{modbus}"}}
  wires: {{kind: wires.hub, process: rig}}
devices:
  io:
    kind: smart_io
    process: rig
    links: {{can: can0, modbus: [tcp], wires: wires}}
    modules: {{1: {{}}, 2: {{}}}}
    terminals: {{in101: rail.pulse, in102: rail.zero, out201: rail.inc, out202: rail.dec}}
    motors: [{{increase: 201, decrease: 202, zero: 102, counter: 101, braking: 2}}]
    can_slave: {{node_id: 31}}
  rail:
    kind: plant.dc-motor
    process: rig
    links: {{wires: wires}}
    increase_wire: rail.inc
    decrease_wire: rail.dec
"""
ABSOLUTE_MOVE, ZERO_POSITION = 1, 6
ORDER, VALUE, READY, POSITION = 16, 17, 320, 16
"""Addresses of docs/devices/pam/smart-io.md."""


class Bench(NamedTuple):
    rig: RunningRig
    node: Any
    client: ModbusTcpClient

    def zero(self) -> None:
        """Find the zero switch by registers: DEC until HIGH."""
        assert not self.client.write_registers(VALUE, [0xFFFF, 0xFFFF, 1, 0]).isError()
        assert not self.client.write_register(ORDER, 0).isError()
        assert not self.client.write_register(ORDER, ZERO_POSITION).isError()
        self.until_ready()

    def until_ready(self) -> None:
        until(lambda: bool(self.client.read_discrete_inputs(READY, count=1).bits[0]))

    def position(self) -> int:
        registers = self.client.read_input_registers(POSITION, count=2).registers
        value = self.client.convert_from_registers(registers, self.client.DATATYPE.INT32, word_order="little")
        assert isinstance(value, int)
        return value


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    can, modbus = free_port(), free_port()
    with RunningRig(RIG.format(can=can, modbus=modbus), None) as rig:
        rig.until_ready()
        client = ModbusTcpClient("127.0.0.1", port=modbus, timeout=10, retries=0)
        with network_on(socketcand_at(can)) as network, client:
            yield Bench(rig, network.add_node(31, str(EDS)), client)


def test_pymodbus_finds_the_zero_of_the_motor_and_moves_it(bench: Bench) -> None:
    bench.zero()
    words = bench.client.convert_to_registers(50, bench.client.DATATYPE.INT32, word_order="little")
    assert not bench.client.write_registers(VALUE, words).isError()
    assert not bench.client.write_register(ORDER, ABSOLUTE_MOVE).isError()
    bench.until_ready()
    assert bench.position() == pytest.approx(50, abs=2), "it coasts for two pulses, on a host that may be late"
    assert bench.rig.value("rail/position") == pytest.approx(50, abs=5)
    assert bench.client.write_register(0, 0x7FFF).isError(), "beyond 10 V"


def test_canopen_moves_the_motor_by_its_eds_file_and_gets_its_pdos(bench: Bench) -> None:
    bench.zero()
    node = bench.node
    assert node.sdo["Manufacturer device name"].raw == "Smart-IO"
    node.nmt.state = "OPERATIONAL"
    node.tpdo.read()
    seen: list[tuple[int, int]] = []
    node.tpdo[4].add_callback(lambda message: seen.append((message[0].raw, message[1].raw)))
    motor = node.sdo["DC motor 1"]
    motor["Order"].raw = 0
    motor["Value"].raw = 30
    motor["Order"].raw = ABSOLUTE_MOVE
    until(lambda: bool(seen) and seen[-1][0] > 20 and seen[-1][1] == 1)
    assert motor["Position in pulses"].raw == seen[-1][0] == pytest.approx(30, abs=2)


def test_outputs_of_canopen_are_coils_of_modbus(bench: Bench) -> None:
    bench.node.sdo["Write outputs 8-bit"][1].raw = 0b1010_0000
    until(lambda: bench.client.read_coils(0, count=12).bits[:8] == [False] * 5 + [True, False, True])
    assert bench.rig.value("io/out108") is True
