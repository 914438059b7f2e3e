"""Foreign masters of the lab: python canopen and pymodbus, each on any of the lab's buses."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import canopen
from canopen_network import BusOf, network_on, socketcand_at
from lab_process import IO32, LEVEL_SENSOR, LabProcess
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.client.base import ModbusBaseSyncClient
from running_rig import until

IO, SENSOR = 5, 6
BOOT_UP, STOPPED, OPERATIONAL, PRE_OPERATIONAL = b"\x00", b"\x04", b"\x05", b"\x7f"


class Heard(NamedTuple):
    data: bytes
    time_s: float
    """The time of the bus, not of the reader."""


def until_last(heard: list[Heard], data: bytes) -> None:
    until(lambda: bool(heard) and heard[-1].data == data)


class CanopenMaster:
    def __init__(self, network: canopen.Network) -> None:
        self.network = network
        self.io: Any = network.add_node(IO, str(IO32))
        self.sensor: Any = network.add_node(SENSOR, str(LEVEL_SENSOR))

    def listen(self, cob_id: int) -> list[Heard]:
        """Return a list of frames of one COB-ID from now on."""
        heard: list[Heard] = []
        self.network.subscribe(cob_id, lambda _id, data, time_s: heard.append(Heard(bytes(data), time_s)))
        return heard

    def send(self, cob_id: int, data: str = "") -> None:
        self.network.send_message(cob_id, bytes.fromhex(data))

    def reset(self) -> None:
        """Both nodes as after power-on: booted, pre-operational, every object at its start value."""
        boots = [self.listen(0x700 + node) for node in (IO, SENSOR)]
        self.network.nmt.send_command(129)
        until(lambda: all(any(beat.data == BOOT_UP for beat in beats) for beats in boots))

    def start(self, *nodes: Any) -> None:
        """Make the nodes operational, as their heartbeats confirm; python canopen only remembers its own command."""
        for node in nodes:
            node.nmt.state = "OPERATIONAL"
            node.sdo[0x1017].raw = 100
            until_last(self.listen(0x700 + node.id), OPERATIONAL)


@contextmanager
def canopen_master(bus: BusOf) -> Iterator[CanopenMaster]:
    with network_on(bus) as network:
        yield CanopenMaster(network)


def socketcand(lab: LabProcess) -> BusOf:
    return socketcand_at(lab.socketcand_port)


def modbus_tcp(lab: LabProcess, timeout_s: float = 10.0) -> ModbusTcpClient:
    return ModbusTcpClient("127.0.0.1", port=lab.modbus_port, timeout=timeout_s, retries=0)


def modbus_rtu(lab: LabProcess, timeout_s: float = 10.0) -> ModbusSerialClient:
    """A pty has no parity, and tcsetattr(3) fails for a client that asks for one."""
    return ModbusSerialClient(str(lab.modbus_pty), baudrate=19200, parity="N", timeout=timeout_s, retries=0)


class Pump:
    """The pump drive as a Modbus master sees it (configs/registers/pump-drive.yaml)."""

    def __init__(self, client: ModbusBaseSyncClient) -> None:
        self._client = client

    def run(self, percent: float) -> None:
        assert not self._client.write_register(0, round(percent * 10), device_id=1).isError()
        assert not self._client.write_coil(0, percent > 0, device_id=1).isError()

    @property
    def level_mm(self) -> int:
        answer = self._client.read_input_registers(0, count=1, device_id=1)
        assert not answer.isError(), answer
        return answer.registers[0]
