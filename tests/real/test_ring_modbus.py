"""The ring of configs/ring.yaml driven by Modbus clients that are not ours: pymodbus (TCP), mbpoll (serial port).

The rig runs once for all tests here; each finds it at rest.
"""

import shutil
import subprocess
from collections.abc import Iterator
from typing import Any

import pytest
from patience import PATIENCE_S
from pymodbus.client import ModbusTcpClient
from ring_process import DRIVES, RingProcess
from running_rig import until

pytestmark = [pytest.mark.real, pytest.mark.timeout(400)]

STATUS, DIAG_CODE, ORDER = 4, 5, 20
"""Registers of the controller."""
# Registers of an axis, as offsets to 1000 + 100 n
ENABLE, OPERATION, COMMAND, AXIS_STATE, AXIS_DIAG_CODE, AXIS_STATUS, POSITION, DIAG_MSG, NAME = (
    0, 1, 13, 20, 22, 23, 24, 40, 80,
)  # fmt: skip
START, RELATIVE, STOP, QUIT = 1, 2, 3, 6
VELOCITY = 1
REACHED = 0x10


class Client:
    def __init__(self, port: int) -> None:
        self._client = ModbusTcpClient("127.0.0.1", port=port, timeout=10)
        assert self._client.connect()  # type: ignore[no-untyped-call]  # as pymodbus is

    def read(self, address: int, count: int = 1) -> list[int]:
        answer = self._client.read_holding_registers(address, count=count, device_id=1)
        assert not answer.isError(), answer
        return list(answer.registers)

    def write(self, address: int, *values: int) -> Any:
        return self._client.write_registers(address, list(values), device_id=1)

    def text(self, address: int, count: int) -> str:
        return b"".join(word.to_bytes(2, "big") for word in self.read(address, count)).split(b"\0")[0].decode("latin-1")

    def signed(self, address: int) -> int:
        high, low = self.read(address, 2)
        return int.from_bytes(high.to_bytes(2, "big") + low.to_bytes(2, "big"), "big", signed=True)

    def enable(self, axis: int) -> None:
        assert not self.write(1000 + 100 * axis + ENABLE, 1).isError()
        until(lambda: bool(self.read(1000 + 100 * axis + AXIS_STATUS)[0] & 4))

    def close(self) -> None:
        self._client.close()  # type: ignore[no-untyped-call]


@pytest.fixture
def client(ring: RingProcess) -> Iterator[Client]:
    client = Client(ring.modbus_port)
    yield client
    client.close()


def test_axes_are_there_with_their_names(client: Client) -> None:
    assert client.read(0, 4) == [0x4D34, client.read(1)[0], 4, 4]
    assert tuple(client.text(1000 + 100 * axis + NAME, 16) for axis in range(4)) == DRIVES


@pytest.mark.manual("PD-004")
def test_client_moves_an_axis_to_a_position_with_one_request(ring: RingProcess, client: Client) -> None:
    client.enable(1)
    before = client.signed(1100 + POSITION)
    # operation 0, +5000 units (5 turns), 10000 units/s, 50000 units/s2 both ways, then: relative
    moved = client.write(1101, 0, 0, 5_000, 0, 10_000, 0, 50_000, 0, 50_000, 0, 0, 0, RELATIVE)
    assert not moved.isError()
    until(lambda: client.signed(1100 + POSITION) - before in range(4_998, 5_003))
    until(lambda: bool(client.read(1100 + AXIS_STATUS)[0] & REACHED))
    assert float(ring.get("film/load_position")) == pytest.approx(
        float(ring.get("film/position")) / 1e6 * 6.2831853 / 5, abs=0.01
    )


def test_client_sets_a_speed_and_stops(ring: RingProcess, client: Client) -> None:
    client.enable(3)
    assert not client.write(1301, VELOCITY, 0, 0, 0, 10_000, 0, 50_000, 0, 50_000, 0, 2_000, 0, START).isError()
    until(lambda: abs(float(ring.get("outfeed/speed")) - 120) < 6)
    assert not client.write(1300 + COMMAND, STOP).isError()
    until(lambda: abs(float(ring.get("outfeed/speed"))) < 2)


def test_start_without_control_is_refused(client: Client) -> None:
    assert client.write(1200 + COMMAND, START).exception_code == 4


@pytest.mark.manual("PD-091", "PD-100")
def test_client_reads_a_diagnosis_and_quits_it(ring: RingProcess, client: Client) -> None:
    client.enable(1)
    ring.fault("film", "dc_bus", "duration_ms=1500")
    until(lambda: client.read(DIAG_CODE) == [2106])
    assert client.read(1100 + AXIS_DIAG_CODE) == [2106]
    assert client.text(1100 + DIAG_MSG, 40) == "communication error DC circuit controller"
    until(lambda: client.read(1100 + AXIS_STATE) == [5])

    def is_quitted() -> bool:
        client.write(1100 + COMMAND, QUIT)
        return client.read(DIAG_CODE) == [0]

    until(is_quitted)
    client.enable(1)


@pytest.mark.skipif(shutil.which("mbpoll") is None, reason="mbpoll is not there")
def test_mbpoll_reads_and_enables_an_axis_at_the_serial_port(ring: RingProcess) -> None:
    until(ring.com1.exists)

    def mbpoll(*words: str) -> str:
        line = ["mbpoll", "-m", "rtu", "-b", "19200", "-P", "none", "-s", "1", "-a", "1", "-0", "-o", "5"]
        done = subprocess.run(
            [*line, *words], capture_output=True, text=True, timeout=PATIENCE_S, check=False, cwd=ring.folder
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    port = str(ring.com1)
    assert "[2]: \t4" in mbpoll("-r", "0", "-c", "4", "-1", port)
    mbpoll("-r", "1000", port, "1")
    until(lambda: ring.get("max4/infeed.AxisState") == 3)
    mbpoll("-r", "1000", port, "0")
    until(lambda: ring.get("max4/infeed.AxisState") == 1)
