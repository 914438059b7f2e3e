"""Masters of foreign libraries on TCP and on serial ports, unchanged, in virtual time: the lab as it is shipped."""

import asyncio
import ftplib
import http.client
import io
import logging
import socket
import threading
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import serial
from doc_pages import ROOT
from pymodbus.client import AsyncModbusSerialClient, AsyncModbusTcpClient, ModbusSerialClient, ModbusTcpClient

from fieldrig import MS, Rig, S, VirtualTimeError, load, virtual_time
from fieldrig.pytest_plugin import MasterRigMaker

pytestmark = [pytest.mark.lean, pytest.mark.long, pytest.mark.timeout(120)]
SERIAL: Any = getattr(serial, "Serial")  # noqa: B009  it has no types
OPEN: Any = getattr(serial, "serial_for_url")  # noqa: B009
LAB, MODEMS = ROOT / "configs" / "lab.yaml", ROOT / "configs" / "modems.yaml"
CONTROLLER: dict[str, Any] = {
    "buses": {
        "lan": {"kind": "tcp.server", "listen": {"http": "127.0.0.1:8088", "ftp": "127.0.0.1:2121"}},
    },
    "devices": {
        "max4": {
            "kind": "max4",
            "links": {"tcp": "lan"},
            "drives": {"belt": {"ring_address": 1, "simulated": True}},
            "ftp": {"user_name": "service", "password": "pacdrive"},
        }
    },
}


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    """Paths of serial ports are those of the run folder, `run/lab` here."""
    monkeypatch.chdir(tmp_path)
    caplog.set_level(logging.CRITICAL)


def lab(fieldrig_master: MasterRigMaker) -> Rig:
    rig = fieldrig_master(LAB)
    assert isinstance(rig, Rig)
    return rig


# ---- Modbus


def test_a_modbus_client_on_tcp_writes_and_reads(fieldrig_master: MasterRigMaker) -> None:
    rig = lab(fieldrig_master)
    with ModbusTcpClient("127.0.0.1", port=5020) as client:
        assert not client.write_register(0, 500).isError()
        assert client.read_input_registers(1).registers == [500]
        assert client.read_holding_registers(0, device_id=99).exception_code == 0x0B
    assert rig.now_ns < 1 * S


def test_the_time_outs_of_a_modbus_client_take_virtual_time_only(fieldrig_master: MasterRigMaker) -> None:
    rig = fieldrig_master(LAB, "buses.mb_tcp.unknown_unit=silence")
    assert isinstance(rig, Rig)
    with ModbusTcpClient("127.0.0.1", port=5020, timeout=3, retries=3) as client:
        begin_ns = rig.now_ns
        with pytest.raises(Exception, match="No response"):
            client.read_holding_registers(0, device_id=99)
        assert rig.now_ns - begin_ns == 12 * S


def test_a_fault_acts_on_a_connection_of_its_own_instant(fieldrig_master: MasterRigMaker) -> None:
    """In real time the port refuses when the call that adds the fault returns."""
    rig = lab(fieldrig_master)
    fault = rig.add_fault("mb_tcp", {"what": "refuse"})
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", 5020))
    assert (rig.now_ns, rig.faults("mb_tcp")[fault]["applied"]) == (0, 1)
    rig.clear_fault("mb_tcp", fault)
    with ModbusTcpClient("127.0.0.1", port=5020) as client:
        assert client.read_input_registers(1).registers == [0]


def test_two_modbus_clients_of_asyncio_share_the_device(fieldrig_master: MasterRigMaker) -> None:
    lab(fieldrig_master)

    async def poll(is_writer: bool, period_s: float) -> list[int]:
        client = AsyncModbusTcpClient("localhost", port=5020)
        assert await client.connect()
        values: list[int] = []
        for step in range(20):
            if is_writer:
                await client.write_register(0, 10 * step)
            values.append((await client.read_input_registers(1)).registers[0])
            await asyncio.sleep(period_s)
        client.close()
        return values

    async def main() -> list[list[int]]:
        return list(await asyncio.gather(poll(True, 0.5), poll(False, 0.71)))

    written, seen = asyncio.run(main())
    assert written == [10 * step for step in range(20)]
    # What was written every 0.5 s, read every 0.71 s.
    assert (seen[0], seen[-1], seen) == (0, 190, sorted(seen))
    assert seen[3:8] == [40, 50, 70, 80, 90]


def test_a_modbus_client_on_a_serial_port_takes_the_time_of_the_line(fieldrig_master: MasterRigMaker) -> None:
    rig = lab(fieldrig_master)
    with ModbusSerialClient("run/lab/modbus-rtu", baudrate=19200, parity="N", timeout=1, retries=3) as client:
        begin_ns = rig.now_ns
        assert client.read_input_registers(0, count=2).registers == [500, 0]
        # 8 bytes of request, 3.5 characters, and 9 bytes of answer, 11 bits each at 19200 bit/s
        line_ns = (8 + 3.5 + 9) * 11 * S / 19200
        assert line_ns <= rig.now_ns - begin_ns < line_ns + 10 * MS
        begin_ns = rig.now_ns
        with pytest.raises(Exception, match="No response"):
            client.read_input_registers(0, device_id=2)
        assert rig.now_ns - begin_ns == pytest.approx(4 * S, abs=50 * MS)


def test_a_modbus_client_of_asyncio_on_a_serial_port(fieldrig_master: MasterRigMaker) -> None:
    lab(fieldrig_master)

    async def main() -> list[int]:
        client = AsyncModbusSerialClient("run/lab/modbus-rtu", baudrate=19200, parity="N", timeout=1)
        assert await client.connect()
        registers = list((await client.read_input_registers(0, count=2)).registers)
        client.close()
        return registers

    assert asyncio.run(main()) == [500, 0]


def test_minimalmodbus_reads_a_register(fieldrig_master: MasterRigMaker) -> None:
    minimalmodbus = pytest.importorskip("minimalmodbus", exc_type=ImportError)
    lab(fieldrig_master)
    assert minimalmodbus.Instrument("run/lab/modbus-rtu", 1).read_register(1, functioncode=4) == 0


# ---- CAN on a serial port, pyserial


def test_python_can_opens_the_lawicel_adapter(fieldrig_master: MasterRigMaker) -> None:
    import can

    lab(fieldrig_master)
    with can.Bus(interface="slcan", channel="run/lab/slcan", bitrate=250_000) as bus:
        bus.send(can.Message(arbitration_id=0, data=[1, 0], is_extended_id=False))
        heard = [bus.recv(2) for _ in range(4)]
    assert [message.arbitration_id for message in heard if message is not None][:2] == [0x705, 0x185]


def test_pyserial_talks_to_a_modem(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(MODEMS)
    with SERIAL("run/modems/serial/office_com", 38400, timeout=2) as port:
        port.write(b"ATE0\r")
        time.sleep(0.1)
        assert port.read(port.in_waiting) == b"ATE0\r\r\nOK\r\n"
        port.write(b"AT\r")
        assert port.read(6) == b"\r\nOK\r\n"
        before_s = time.monotonic()
        assert port.read(1) == b""
        assert time.monotonic() - before_s == 2


LINES: dict[str, Any] = {
    "buses": {
        "com": {"kind": "serial.virtual", "baud": 38400},
        "telephone": {"kind": "telephone.virtual", "numbers": {"office": "100"}},
    },
    "devices": {"office": {"kind": "modem", "links": {"line": "com", "telephone": "telephone"}}},
}


@pytest.mark.parametrize(
    ("keys", "url"),
    [({}, "fieldrig://com"), ({"path": "ttyS0"}, "run/rig/ttyS0"), ({"path": "ttyS0"}, "fieldrig://com"),
     ({"listen": "127.0.0.1:7000"}, "socket://127.0.0.1:7000")],
)  # fmt: skip
def test_a_line_in_virtual_time_is_opened_by_its_name_or_address(
    fieldrig_master: MasterRigMaker, keys: dict[str, str], url: str
) -> None:
    buses = {**LINES["buses"], "com": {**LINES["buses"]["com"], **keys}}
    fieldrig_master({**LINES, "buses": buses})
    with OPEN(url, 38400, timeout=2) as port:
        port.write(b"ATE0\r")
        assert port.read(12) == b"ATE0\r\r\nOK\r\n"


def test_a_program_sees_and_sets_the_control_lines_of_a_line(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(LINES)
    with OPEN("fieldrig://com", 38400, timeout=1) as port:
        time.sleep(0.1)
        assert (port.cts, port.dsr, port.ri, port.cd) == (True, True, False, False)
        port.write(b"AT&C0\r")
        time.sleep(0.1)
        assert port.cd
        port.write(b"AT&D2E0\r")
        port.dtr = False
        port.send_break()
        time.sleep(0.5)
        port.dtr = True


@pytest.mark.parametrize("keys", [{"pty": "mb"}, {"listen": "127.0.0.1:5021"}, {}])
def test_a_modbus_line_in_virtual_time_takes_the_time_of_the_line(
    fieldrig_master: MasterRigMaker, keys: dict[str, str]
) -> None:
    drive = {"kind": "modbus.device", "unit_id": 1, "table": str(ROOT / "configs/registers/pump-drive.yaml")}
    rig = fieldrig_master(
        {
            "buses": {"mb": {"kind": "modbus.virtual", "baud": 19200, **keys}, "wires": {"kind": "wires.virtual"}},
            "devices": {"drive": {**drive, "links": {"modbus": ["mb"], "wires": "wires"}}},
        }
    )
    assert isinstance(rig, Rig)
    port = "run/rig/mb" if "pty" in keys else "socket://127.0.0.1:5021" if "listen" in keys else "fieldrig://mb"
    with ModbusSerialClient(port, baudrate=19200, timeout=1) as client:
        begin_ns = rig.now_ns
        assert client.read_input_registers(0, count=2).registers == [0, 0]
        line_ns = (8 + 3.5 + 9) * 11 * S / 19200
        # The client asks again after some milliseconds; by socket:// it gets one byte each time.
        assert line_ns <= rig.now_ns - begin_ns < line_ns + 40 * MS


def test_a_url_of_no_line_is_refused(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(LINES)
    with pytest.raises(serial.SerialException, match="No such file"):
        OPEN("fieldrig://con")


def test_a_url_of_a_line_outside_of_virtual_time_is_refused() -> None:
    with pytest.raises(serial.SerialException, match="fieldrig://com needs"):
        OPEN("fieldrig://com")


def test_a_device_of_the_host_is_refused() -> None:
    is_refused = pytest.raises(VirtualTimeError, match="/dev/ttyS0 is a device of this host")
    with is_refused, Rig(load(LAB, ["time=virtual"])) as rig, virtual_time(rig):
        SERIAL("/dev/ttyS0")


# ---- the standard library, asyncua


@pytest.mark.long
def test_http_and_ftp_of_the_standard_library(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(CONTROLLER)
    with urllib.request.urlopen("http://127.0.0.1:8088/", timeout=10) as page:
        assert page.status == 200
    connection = http.client.HTTPConnection("localhost", 8088, timeout=5)
    connection.request("GET", "/")
    assert connection.getresponse().status == 200
    connection.close()
    with ftplib.FTP() as ftp:
        ftp.connect("127.0.0.1", 2121, timeout=10)
        ftp.login("service", "pacdrive")
        ftp.storbinary("STOR A.TXT", io.BytesIO(b"hello"))
        received: list[bytes] = []
        ftp.retrbinary("RETR A.TXT", received.append)
        assert received == [b"hello"]


@pytest.mark.long
def test_the_client_of_asyncua_reads_and_browses(fieldrig_master: MasterRigMaker) -> None:
    from asyncua import Client

    devices = {"max4": {**CONTROLLER["devices"]["max4"], "links": {"tcp": "lan", "opcua": "ua"}}}
    buses = {**CONTROLLER["buses"], "ua": {"kind": "opcua.server", "listen": "127.0.0.1:14856"}}
    fieldrig_master({"buses": buses, "devices": devices})

    async def main() -> tuple[int, list[str]]:
        async with Client("opc.tcp://127.0.0.1:14856") as client:
            children = await client.nodes.objects.get_children()
            names = [(await child.read_browse_name()).Name for child in children]
            return int(await client.nodes.server_state.read_value()), names

    state, names = asyncio.run(main())
    assert state == 0
    assert "Server" in names


# ---- all at once


@pytest.mark.long
def test_masters_in_three_threads_give_the_same_each_time() -> None:
    def run() -> tuple[list[int], int]:
        values: list[int] = []
        with Rig(load(LAB, ["time=virtual"])) as rig, virtual_time(rig):

            def write_and_read() -> None:
                with ModbusTcpClient("127.0.0.1", port=5020) as client:
                    for step in range(50):
                        client.write_register(0, step * 5)
                        time.sleep(0.1)
                        values.append(client.read_input_registers(1).registers[0])

            def poll() -> None:
                async def main() -> None:
                    client = AsyncModbusTcpClient("127.0.0.1", port=5020)
                    await client.connect()
                    for _ in range(50):
                        values.append((await client.read_input_registers(1)).registers[0])
                        await asyncio.sleep(0.07)
                    client.close()

                asyncio.run(main())

            def read_line() -> None:
                with ModbusSerialClient("run/lab/modbus-rtu", baudrate=19200, parity="N") as client:
                    values.extend(client.read_input_registers(1).registers[0] for _ in range(50))

            works: list[Callable[[], None]] = [write_and_read, poll, read_line]
            threads = [threading.Thread(target=work) for work in works]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            return values, rig.now_ns

    first = run()
    assert len(first[0]) == 150
    assert run() == first
