"""pymodbus' client and mbpoll, Modbus masters that are not ours, on the running lab by TCP and RTU."""

import re
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from lab_masters import CanopenMaster, Pump, modbus_rtu, modbus_tcp
from lab_process import LabProcess
from pymodbus.client.base import ModbusBaseSyncClient
from pymodbus.exceptions import ModbusIOException
from pymodbus.pdu import ModbusPDU
from running_rig import until

pytestmark = pytest.mark.real

LINKS = {"tcp": modbus_tcp, "rtu": modbus_rtu}
SPEED_SET, RAMP_TIME, LEVEL_LIMIT, LOCATION = 0, 1, 2, 3
TURNAROUND_S = 0.1
"""The silence that a master leaves after a broadcast (V1.02, 2.4.1), which pymodbus does not keep by itself."""
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE, SERVER_FAILURE = 1, 2, 3, 4


@pytest.fixture(params=LINKS)
def client(request: pytest.FixtureRequest, lab: LabProcess) -> Iterator[ModbusBaseSyncClient]:
    with LINKS[request.param](lab) as client:
        yield client


def registers(answer: ModbusPDU) -> list[int]:
    assert not answer.isError(), answer
    return list(answer.registers)


def done(answer: ModbusPDU) -> None:
    assert not answer.isError(), answer


def test_every_space_is_read(client: ModbusBaseSyncClient) -> None:
    assert client.read_coils(0, count=2).bits[:2] == [False, False]
    assert client.read_discrete_inputs(0, count=2).bits[:2] == [False, False]
    assert registers(client.read_holding_registers(SPEED_SET, count=3)) == [0, 50, 1800]
    assert registers(client.read_input_registers(0, count=2)) == [500, 0]


def test_values_of_several_registers(client: ModbusBaseSyncClient) -> None:
    text = registers(client.read_holding_registers(LOCATION, count=8))
    assert client.convert_from_registers(text, client.DATATYPE.STRING) == "lab"
    flow = registers(client.read_input_registers(2, count=2))
    assert client.convert_from_registers(flow, client.DATATYPE.FLOAT32) == 0.0
    temperature = registers(client.read_input_registers(4, count=1))
    assert client.convert_from_registers(temperature, client.DATATYPE.INT16) == 315


def test_every_way_of_writing(client: ModbusBaseSyncClient) -> None:
    done(client.write_coil(1, True))
    done(client.write_register(RAMP_TIME, 120))
    assert client.read_coils(1, count=1).bits[0]
    assert registers(client.read_holding_registers(RAMP_TIME, count=1)) == [120]
    done(client.write_coils(0, [False, False]))
    done(client.write_registers(RAMP_TIME, [60, 1750]))
    assert not client.read_coils(1, count=1).bits[0]
    assert registers(client.read_holding_registers(RAMP_TIME, count=2)) == [60, 1750]
    done(client.mask_write_register(address=RAMP_TIME, and_mask=0xFFF0, or_mask=0x0002))
    answer = client.readwrite_registers(read_address=RAMP_TIME, read_count=2, write_address=LEVEL_LIMIT, values=[1800])
    assert registers(answer) == [60 & 0xFFF0 | 2, 1800]  # written before it is read


def test_the_device_says_what_it_is(client: ModbusBaseSyncClient) -> None:
    identification: Any = client.read_device_information()
    assert {key: text.decode() for key, text in identification.information.items()}.keys() == {0, 1, 2}
    assert not client.report_device_id().isError()
    status: Any = client.read_exception_status()
    assert status.status == 0
    echo: Any = client.diag_query_data(b"\xa5\x37")
    assert echo.message == b"\xa5\x37"


def test_fifo_queue_is_read(lab: LabProcess) -> None:
    with modbus_tcp(lab) as tcp:  # by RTU pymodbus 3.16 takes the answer for two bytes shorter than it is
        queue: Any = tcp.read_fifo_queue(address=100)
    assert queue.values == [1, 7]


def test_what_may_not_be_has_its_exception(client: ModbusBaseSyncClient) -> None:
    cases: list[tuple[Callable[[], ModbusPDU], int]] = [
        (lambda: client.read_holding_registers(11, count=1), ILLEGAL_ADDRESS),
        (lambda: client.read_holding_registers(10, count=2), ILLEGAL_ADDRESS),
        (lambda: client.read_coils(2, count=1), ILLEGAL_ADDRESS),
        (lambda: client.write_register(11, 0), ILLEGAL_ADDRESS),
        (lambda: client.write_register(SPEED_SET, 1001), SERVER_FAILURE),  # above 100 %
        (lambda: client.read_file_record([]), ILLEGAL_FUNCTION),
    ]
    for number, (ask, code) in enumerate(cases):
        answer = ask()
        assert answer.isError(), number
        assert answer.exception_code == code, number
    assert registers(client.read_holding_registers(SPEED_SET, count=1)) == [0]


def test_what_one_link_writes_the_other_reads(lab: LabProcess) -> None:
    with modbus_tcp(lab) as tcp, modbus_rtu(lab) as rtu:
        for number, (writer, reader) in enumerate(((tcp, rtu), (rtu, tcp))):
            done(writer.write_register(RAMP_TIME, 70 + number))
            assert registers(reader.read_holding_registers(RAMP_TIME, count=1)) == [70 + number]


def test_other_units_on_the_serial_line_are_silence(lab: LabProcess) -> None:
    with modbus_rtu(lab, timeout_s=0.3) as rtu, pytest.raises(ModbusIOException):
        rtu.read_coils(0, count=1, device_id=2)


def test_broadcast_is_done_and_not_answered(lab: LabProcess) -> None:
    with modbus_rtu(lab, timeout_s=1.0) as rtu:

        def is_done() -> bool:
            rtu.write_register(RAMP_TIME, 90, device_id=0, no_response_expected=True)
            time.sleep(TURNAROUND_S)
            try:
                return registers(rtu.read_holding_registers(RAMP_TIME, count=1)) == [90]
            except ModbusIOException:  # the hub was blocked during the turnaround delay, and took both for one frame
                return False

        until(is_done)


def test_pump_fills_the_tank(client: ModbusBaseSyncClient, master: CanopenMaster) -> None:
    pump = Pump(client)
    before_mm = pump.level_mm
    pump.run(100)
    until(lambda: pump.level_mm >= before_mm + 4)
    assert client.read_discrete_inputs(0, count=1).bits[0]
    flow = registers(client.read_input_registers(2, count=2))
    assert client.convert_from_registers(flow, client.DATATYPE.FLOAT32) == pytest.approx(0.001)
    assert master.io.sdo[0x6401][1].raw >= 10 * (before_mm + 4)
    pump.run(0)
    assert not client.read_discrete_inputs(0, count=1).bits[0]


@pytest.fixture(params=LINKS)
def mbpoll(request: pytest.FixtureRequest, lab: LabProcess) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Runs it with options, and at the end what to write."""
    if shutil.which("mbpoll") is None:
        pytest.skip("mbpoll is not installed")
    way, place = ["-m", "tcp", "-p", str(lab.modbus_port)], "127.0.0.1"
    if request.param == "rtu":
        way, place = ["-m", "rtu", "-b", "19200", "-P", "none", "-s", "1"], str(lab.modbus_pty)

    def run(options: str, *values: str) -> subprocess.CompletedProcess[str]:
        command = ["mbpoll", *way, "-a", "1", "-0", *options.split(), place, *values]
        return subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)

    return run


def shown(done: subprocess.CompletedProcess[str]) -> dict[int, str]:
    """The values that it prints, by address."""
    assert done.returncode == 0, done.stdout + done.stderr
    return {int(address): value for address, value in re.findall(r"^\[(\d+)\]:\s+(.*)$", done.stdout, re.MULTILINE)}


Mbpoll = Callable[..., subprocess.CompletedProcess[str]]


def test_mbpoll_reads_every_space(mbpoll: Mbpoll) -> None:
    assert shown(mbpoll("-1 -t 0 -r 0 -c 2")) == {0: "0", 1: "0"}
    assert shown(mbpoll("-1 -t 1 -r 0 -c 2")) == {0: "0", 1: "0"}
    assert shown(mbpoll("-1 -t 4 -r 0 -c 3")) == {0: "0", 1: "50", 2: "1800"}
    assert shown(mbpoll("-1 -t 3 -r 0 -c 2")) == {0: "500", 1: "0"}
    assert shown(mbpoll("-1 -t 3:float -B -r 2 -c 1")) == {2: "0"}


def test_mbpoll_fills_the_tank(lab: LabProcess, mbpoll: Mbpoll) -> None:
    assert mbpoll("-t 4 -r 0", "1000").returncode == 0
    assert mbpoll("-t 0 -r 0", "1").returncode == 0
    until(lambda: int(shown(mbpoll("-1 -t 3 -r 0 -c 1"))[0]) > 503)
    assert float(shown(mbpoll("-1 -t 3:float -B -r 2 -c 1"))[2]) == pytest.approx(0.001)


def test_mbpoll_gets_the_reason_for_a_refusal(mbpoll: Mbpoll) -> None:
    refused = mbpoll("-1 -t 4 -r 11 -c 1")
    assert "Illegal data address" in refused.stderr + refused.stdout
    refused = mbpoll("-t 4 -r 0", "1001")
    assert "failure" in refused.stderr + refused.stdout
