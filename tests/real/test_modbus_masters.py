"""Foreign Modbus masters at our buses: pymodbus in every framing, mbpoll (which is libmodbus) on TCP and RTU."""

import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from modbus_bench import RealBench, ascii_bus, real_bench, rtu_bus, tcp_bus
from pymodbus import FramerType
from pymodbus.client import ModbusSerialClient, ModbusTcpClient

from fieldrig_bus.modbus.kind import ModbusBus

pytestmark = [pytest.mark.real, pytest.mark.system]

BAUD = 115200
TABLE = """
coils: [{address: 0, name: coil, count: 32}]
discrete_inputs: [{address: 0, name: input, count: 20, initial: true}]
holding_registers:
  - {address: 0, name: register, count: 130}
  - {address: 200, name: number, type: f32, initial: 1.5}
  - {address: 202, name: counter, type: s32, initial: -70000}
input_registers:
  - {address: 0, name: reading, count: 10, initial: 258}
  - {address: 20, name: flow, type: f32, initial: -2.25}
fifos: [{address: 100, name: queue, initial: [1, 2, 3]}]
"""
SERVER_ID = {"server_id": "2A", "additional": "fieldrig"}
BUSES: dict[str, Callable[[], ModbusBus]] = {
    "tcp": tcp_bus,
    "rtu pty": lambda: rtu_bus(baud=BAUD),
    "rtu tcp": lambda: rtu_bus(pty=None, listen="127.0.0.1:0", baud=BAUD),
    "ascii pty": lambda: ascii_bus(baud=BAUD),
    "ascii tcp": lambda: ascii_bus(pty=None, listen="127.0.0.1:0", baud=BAUD),
}


def client(bench: RealBench, bus: str) -> Any:
    """pymodbus types every answer as a mere ModbusPDU."""
    framer = {"tcp": FramerType.SOCKET, "rtu": FramerType.RTU, "ascii": FramerType.ASCII}[bus.split()[0]]
    if "pty" in bus:
        # A pty has neither parity nor 7 bits; Linux refuses pyserial when it asks for them.
        line = str(bench.run / "line")
        return ModbusSerialClient(line, framer=framer, baudrate=BAUD, parity="N", timeout=10)
    return ModbusTcpClient("127.0.0.1", port=bench.port, framer=framer, timeout=10)


@pytest.mark.parametrize("bus", BUSES)
def test_pymodbus_reads_and_writes_everything(bus: str) -> None:
    def work(master: Any) -> None:
        assert master.connect()
        assert not master.write_coils(3, [True, False, True] * 4).isError()
        assert not master.write_coil(31, True).isError()
        assert master.read_coils(3, count=12).bits[:12] == [True, False, True] * 4
        assert master.read_coils(31, count=1).bits[0] is True
        assert master.read_discrete_inputs(0, count=20).bits[:20] == [True] * 20
        values = list(range(123))
        assert not master.write_registers(0, values).isError()
        assert not master.write_register(124, 0xFFFF).isError()
        assert master.read_holding_registers(0, count=125).registers == [*values, 0, 0xFFFF]
        assert master.read_input_registers(0, count=10).registers == [258] * 10
        assert not master.mask_write_register(address=10, and_mask=0xF2, or_mask=0x25).isError()
        assert master.read_holding_registers(10, count=1).registers == [10 & 0xF2 | 0x25 & ~0xF2]
        both = master.readwrite_registers(read_address=0, read_count=3, write_address=1, values=[7, 8])
        assert both.registers == [0, 7, 8]
        if "rtu" not in bus:  # pymodbus 3.16.1 forgets the CRC in the size of this response
            assert master.read_fifo_queue(address=100).values == [1, 2, 3]
        assert master.read_device_information(read_code=3, object_id=0).information[0] == b"Company identification"
        assert master.report_device_id().identifier.startswith(b"\x2a")
        assert master.read_exception_status().status == 0x6D
        assert master.diag_query_data(b"\xa5\x37").message == b"\xa5\x37"
        assert master.diag_read_bus_message_count().message > 10
        assert master.diag_read_bus_exception_error_count().message == 0
        assert master.read_coils(30, count=3).exception_code == 2

    with real_bench(BUSES[bus](), TABLE, server_id=SERVER_ID) as bench:
        master = client(bench, bus)
        try:
            bench.in_thread(lambda: work(master))
        finally:
            master.close()


@contextmanager
def polled(bus: str) -> Iterator[Callable[..., str]]:
    """mbpoll with these options and written values, once; what it prints."""
    mbpoll = shutil.which("mbpoll")
    assert mbpoll, "mbpoll is not installed (Debian: mbpoll)"
    with real_bench(BUSES[bus](), TABLE, server_id=SERVER_ID) as bench:
        way = ["-m", "tcp", "-p", str(bench.port)] if bus == "tcp" else ["-m", "rtu", "-b", str(BAUD), "-P", "even"]
        target = "127.0.0.1" if bus == "tcp" else str(bench.run / "line")

        def poll(options: str, *values: str) -> str:
            command = [mbpoll, *way, "-0", "-1", "-o", "10", *options.split(), target, *values]
            done = bench.in_thread(lambda: subprocess.run(command, capture_output=True, text=True, timeout=60))
            return done.stdout + done.stderr

        yield poll


@pytest.mark.parametrize("bus", ["tcp", "rtu pty"])
def test_mbpoll_reads_and_writes(bus: str) -> None:
    with polled(bus) as poll:
        assert "Written 1 references." in poll("-a 1 -t 0 -r 3", "1")
        assert "[3]: \t1" in poll("-a 1 -t 0 -r 3")
        assert "[19]: \t1" in poll("-a 1 -t 1 -r 0 -c 20")
        assert "Written 2 references." in poll("-a 1 -t 4 -r 5", "1234", "65535")
        assert "[5]: \t1234" in poll("-a 1 -t 4 -r 5")
        assert "[9]: \t258" in poll("-a 1 -t 3 -r 0 -c 10")
        assert "[200]: \t1.5" in poll("-a 1 -t 4:float -B -r 200")
        assert "[202]: \t-70000" in poll("-a 1 -t 4:int -B -r 202")
        assert "[20]: \t-2.25" in poll("-a 1 -t 3:float -B -r 20")
        assert "Illegal data address" in poll("-a 1 -t 4 -r 150")


def test_mbpoll_asks_a_line_who_it_is() -> None:
    with polled("rtu pty") as poll:
        said = poll("-a 1 -u")
        assert "Id    : 0x2a" in said.replace("2A", "2a")
        assert "Status: On" in said
        assert "Data  : fieldrig" in said
