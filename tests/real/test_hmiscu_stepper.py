"""Foreign Modbus masters, pymodbus and mbpoll, move a stepper through the pulse output of a running HMISCU."""

import re
import shutil
import subprocess
from collections.abc import Iterator
from math import tau

import pytest
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.client.base import ModbusBaseSyncClient
from running_rig import RunningRig, until

from fieldrig.testing import free_port

pytestmark = pytest.mark.real

RIG = """
time: real
buses:
  tcp: {{kind: modbus.tcp, listen: "127.0.0.1:{port}"}}
  com1: {{kind: modbus.rtu, pty: com1, baud: 19200}}
  wires: {{kind: wires.hub}}
devices:
  scu:
    kind: hmiscu
    links: {{modbus: [tcp, com1], wires: wires}}
    channel_0: {{mode: pto, aux: drive_ready}}
    terminals: {{FQ0: pulse, FQ1: direction, DI2: axis.ready}}
  axis:
    kind: plant.stepper
    links: {{wires: wires}}
    pulse_wire: pulse
    direction_wire: direction
    pulses_per_turn: 2000
    pull_out: [[0, 2.0], [10, 1.0]]
    motor_inertia_kg_m2: 0.0001
"""
PULSES = 4_000
# Addresses of docs/devices/hmiscu/hmiscu.md.
RESET, EXECUTE = 0, 2  # coils
PTO_ERROR, DONE = 0, 8  # discrete inputs
VELOCITY, DIRECTION, SENT = 0, 8, 2  # holding registers, and the input register Distance


@pytest.fixture(scope="module")
def rig() -> Iterator[tuple[RunningRig, int]]:
    port = free_port()
    with RunningRig(RIG.format(port=port), None) as rig:
        rig.until_ready()
        until(lambda: rig.value("scu/DI2"))
        yield rig, port


@pytest.fixture(params=["tcp", "rtu"])
def client(request: pytest.FixtureRequest, rig: tuple[RunningRig, int]) -> Iterator[ModbusBaseSyncClient]:
    running, port = rig
    client: ModbusBaseSyncClient = (
        ModbusTcpClient("127.0.0.1", port=port, timeout=10, retries=0)
        if request.param == "tcp"
        else ModbusSerialClient(str(running.run / "com1"), baudrate=19200, parity="N", timeout=10, retries=0)
    )
    with client:
        yield client


def is_on(client: ModbusBaseSyncClient, address: int) -> bool:
    answer = client.read_discrete_inputs(address, count=1)
    assert not answer.isError(), answer
    return answer.bits[0]


def ready(client: ModbusBaseSyncClient) -> None:
    """Reset the error that the axis has because the drive became ready after the controller."""
    client.write_coil(EXECUTE, False)
    client.write_coil(RESET, True)
    until(lambda: not is_on(client, PTO_ERROR))
    client.write_coil(RESET, False)


def recipe(client: ModbusBaseSyncClient, *values: int) -> list[int]:
    """Velocity, distance and the two ramps as registers, each with its low word first."""
    type = client.DATATYPE.UINT32
    return [word for value in values for word in client.convert_to_registers(value, type, word_order="little")]


@pytest.mark.parametrize("direction", [0, 1])
def test_pymodbus_moves_the_motor_there_and_back(
    client: ModbusBaseSyncClient, rig: tuple[RunningRig, int], direction: int
) -> None:
    running, _ = rig
    ready(client)
    before = running.value("axis/position")
    assert not client.write_registers(VELOCITY, recipe(client, 10_000, PULSES, 100, 100)).isError()
    client.write_register(DIRECTION, direction)
    assert not client.write_coil(EXECUTE, True).isError()
    until(lambda: is_on(client, DONE))
    sent = client.convert_from_registers(
        client.read_input_registers(SENT, count=2).registers, client.DATATYPE.UINT32, word_order="little"
    )
    assert sent == PULSES
    sign = -1 if direction else 1
    until(lambda: running.value("axis/position") == pytest.approx(before + sign * PULSES / 2_000 * tau, abs=1e-9))
    assert running.value("axis/lost") == 0


def test_mbpoll_moves_the_motor(rig: tuple[RunningRig, int]) -> None:
    if shutil.which("mbpoll") is None:
        pytest.skip("mbpoll is not installed")
    running, port = rig

    def mbpoll(options: str, *values: str) -> str:
        command = ["mbpoll", "-m", "tcp", "-p", str(port), "-a", "1", "-0", *options.split(), "127.0.0.1", *values]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    with ModbusTcpClient("127.0.0.1", port=port, timeout=10, retries=0) as client:
        ready(client)
    before = running.value("axis/position")
    mbpoll("-t 4:int -r 0", "10000", str(PULSES), "100", "100")
    mbpoll("-t 4 -r 8", "0")
    mbpoll("-t 0 -r 2", "1")
    until(lambda: re.search(r"^\[8\]:\s+1$", mbpoll("-1 -t 1 -r 8 -c 1"), re.MULTILINE) is not None)
    until(lambda: running.value("axis/position") == pytest.approx(before + PULSES / 2_000 * tau, abs=1e-9))
