"""pymodbus, a Modbus client that is not ours, moves an axis of a running MAx-4 over TCP and over its serial port."""

from collections.abc import Iterator
from typing import Any

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
devices:
  max4:
    kind: max4
    links: {{modbus: [tcp, com1]}}
    drives: {{belt: {{ring_address: 1, simulated: true}}}}
    program: {program}
    autostart: true
"""
PROGRAM = """
PROGRAM PLC_PRG
VAR
  setpoint AT %MW10 : INT;
  doubled AT %MW11 : INT;
  on AT %MX12.0 : BOOL;
  cycles AT %MD10 : DWORD;
  same AT %MX12.3 : BOOL;
  same_too AT %MX12.4 : BOOL;
END_VAR
doubled := setpoint * 2;
same := on;
same_too := on;
IF on THEN cycles := cycles + 1; END_IF
END_PROGRAM
"""
MARKERS = 0x8000
BELT = 1000
ENABLE, TARGET, SPEED, COMMAND, STATUS, POSITION, DIAG_CODE = 1000, 1002, 1004, 1013, 1023, 1024, 1022
START, QUIT = 1, 6
CONTROLLED, REACHED = 0x04, 0x10


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[RunningRig, int]]:
    port = free_port()
    program = tmp_path_factory.mktemp("program") / "doubling.st"
    program.write_text(PROGRAM)
    with RunningRig(RIG.format(port=port, program=program), None) as rig:
        rig.until_ready()
        until(lambda: rig.value("max4/booted"))
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


@pytest.mark.manual("PD-283")
def test_each_tcp_connection_is_an_entry_of_the_log(rig: tuple[RunningRig, int]) -> None:
    running, port = rig

    def logged() -> int:
        lines: str = running.value("max4/log")
        return lines.count("\t0x1000\tLZS\tLZS\t8013\t7f000001\tconnect to TCP/IP server")

    before = logged()
    for number in (1, 2):
        with ModbusTcpClient("127.0.0.1", port=port, timeout=10, retries=0) as client:
            assert read(client, 0) == 0x4D34
            until(lambda number=number: logged() == before + number)  # type: ignore[misc]  # bound now
    with ModbusSerialClient(str(running.run / "com1"), baudrate=19200, parity="N", timeout=10, retries=0) as line:
        assert read(line, 0) == 0x4D34  # a serial line has no connections
    assert logged() == before + 2


def read(client: ModbusBaseSyncClient, address: int, type: Any = None) -> Any:
    type = type or client.DATATYPE.UINT16
    answer = client.read_holding_registers(address, count=type.value[1])
    assert not answer.isError(), answer
    return client.convert_from_registers(answer.registers, type)


def write(client: ModbusBaseSyncClient, address: int, value: int, type: Any = None) -> None:
    words = client.convert_to_registers(value, type or client.DATATYPE.UINT16)
    answer = client.write_registers(address, words)
    assert not answer.isError(), answer


@pytest.mark.manual("PD-306", "PD-289")
def test_a_foreign_client_moves_an_axis(client: ModbusBaseSyncClient, rig: tuple[RunningRig, int]) -> None:
    long, unsigned = client.DATATYPE.INT32, client.DATATYPE.UINT32
    assert read(client, 0) == 0x4D34
    write(client, ENABLE, 1)
    until(lambda: read(client, STATUS) & CONTROLLED)
    target = 700 - read(client, POSITION, long)
    write(client, TARGET, target, long)
    write(client, SPEED, 2000, unsigned)
    write(client, COMMAND, START)
    until(lambda: read(client, STATUS) & REACHED)
    assert read(client, POSITION, long) == target
    assert rig[0].value("max4/belt.Position") == target * 1000
    write(client, ENABLE, 0)
    until(lambda: not read(client, STATUS) & CONTROLLED)
    refused = client.write_register(COMMAND, START)
    assert (refused.isError(), refused.exception_code) == (True, 4)
    write(client, COMMAND, QUIT)
    assert read(client, DIAG_CODE) == 0


@pytest.mark.manual("PD-306")
def test_a_client_reads_and_sets_variables_of_the_program(client: ModbusBaseSyncClient) -> None:
    assert not client.write_register(MARKERS + 10, 0x10000 - 21).isError()
    until(lambda: read(client, MARKERS + 11) == 0x10000 - 42)
    assert not client.write_coil(MARKERS + 16 * 12, True).isError()
    until(lambda: read(client, MARKERS + 20) > 0)
    assert not client.write_coil(MARKERS + 16 * 12, False).isError()


def test_a_client_forces_coils_of_the_program(client: ModbusBaseSyncClient, rig: tuple[RunningRig, int]) -> None:
    """Functions 5 and 15: Force Single Coil and Force Multiple Coils, as the protocol calls them."""
    first = MARKERS + 16 * 12
    for bits in ([True, False, True], [False, True, True]):
        assert not client.write_coils(first, bits).isError()
        until(lambda bits=bits: client.read_coils(first, count=5).bits[:5] == [*bits, bits[0], bits[0]])  # type: ignore[misc]
    assert not client.write_coil(first, True).isError()
    until(lambda: client.read_coils(first, count=5).bits[:5] == [True, True, True, True, True])
    rig[0].ask("device/max4/debug", {"command": "force", "values": {"PLC_PRG.on": False}})
    assert not client.write_coil(first, True).isError()
    until(lambda: client.read_coils(first, count=5).bits[:5] == [False, True, True, False, False])
    rig[0].ask("device/max4/debug", {"command": "release", "names": ["PLC_PRG.on"]})
