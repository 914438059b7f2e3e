"""An unchanged Modbus master in virtual time, while its bus and its device have faults: no time-out costs wall time."""

import asyncio
import logging
import socket
import time
from pathlib import Path
from typing import Any

import pytest
import serial
from doc_pages import ROOT
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.exceptions import ModbusException
from pymodbus.framer import FramerRTU

from fieldrig import Rig, S
from fieldrig.pytest_plugin import MasterRigMaker

pytestmark = [pytest.mark.lean, pytest.mark.long, pytest.mark.timeout(120)]
OPEN: Any = getattr(serial, "Serial")  # noqa: B009  it has no types
LAB = ROOT / "configs" / "lab.yaml"
LINE = "run/lab/modbus-rtu"


@pytest.fixture
def rig(
    fieldrig_master: MasterRigMaker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> Rig:
    monkeypatch.chdir(tmp_path)
    caplog.set_level(logging.CRITICAL)
    made = fieldrig_master(LAB)
    assert isinstance(made, Rig)
    return made


def rtu(body: bytes) -> bytes:
    return body + FramerRTU.compute_CRC(body).to_bytes(2, "big")


def test_a_late_answer_is_a_time_out_of_the_master_and_the_next_request_works(rig: Rig) -> None:
    rig.add_fault("mb_tcp", {"what": "delay", "delay_ms": 30_000, "nth": 2, "count": 1})
    with ModbusTcpClient("127.0.0.1", port=5020, timeout=20, retries=0) as client:
        assert not client.write_register(0, 500).isError()
        begin_ns = rig.now_ns
        with pytest.raises(ModbusException):
            client.read_input_registers(1)
        assert rig.now_ns - begin_ns == 20 * S
    with ModbusTcpClient("127.0.0.1", port=5020) as client:
        assert client.read_input_registers(1).registers == [500]


def test_a_master_repeats_its_request_after_a_wrong_crc(rig: Rig) -> None:
    number = rig.add_fault("mb_rtu", {"what": "wrong_crc", "count": 2})
    with ModbusSerialClient(LINE, baudrate=19200, parity="N", timeout=5, retries=3) as client:
        begin_ns = rig.now_ns
        assert client.read_input_registers(0, count=2).registers == [500, 0]
        assert 10 * S <= rig.now_ns - begin_ns < 11 * S
    assert rig.faults("mb_rtu")[number]["applied"] == 2


def test_pyserial_reads_the_bytes_that_the_fault_makes(rig: Rig) -> None:
    rig.add_fault("mb_rtu", {"what": "garbage", "data": "00 FE"})
    with OPEN(LINE, 19200, timeout=1) as port:
        port.write(rtu(bytes.fromhex("01 04 0000 0002")))
        assert port.read(100) == b"\x00\xfe" + rtu(bytes.fromhex("01 04 04 01F4 0000"))


def test_a_connection_is_refused_while_the_fault_is_on(rig: Rig) -> None:
    number = rig.add_fault("mb_tcp", {"what": "refuse", "duration_ms": 10_000})
    time.sleep(1)
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", 5020), 5)
    client: Any = ModbusTcpClient("127.0.0.1", port=5020)
    assert not client.connect()
    assert rig.faults("mb_tcp")[number]["state"] == "on"
    time.sleep(10)
    with ModbusTcpClient("127.0.0.1", port=5020) as again:
        assert again.read_input_registers(0, count=1).registers == [500]


def test_a_connection_that_is_cut_and_a_device_without_power(rig: Rig) -> None:
    rig.add_fault("mb_tcp", {"what": "cut", "count": 1})
    with ModbusTcpClient("127.0.0.1", port=5020, timeout=3, retries=0) as client:
        with pytest.raises(ModbusException, match="closed"):
            client.read_input_registers(0, count=1)
        assert client.read_input_registers(0, count=1).registers == [500]
        rig.add_fault("drive", {"what": "power_off", "duration_ms": 5_000})
        assert client.read_input_registers(0, count=1).exception_code == 0x0B  # of the gateway that the bus is
        time.sleep(6)
        assert client.read_input_registers(0, count=1).registers == [500]


def test_a_silent_controller_keeps_nothing_else_of_an_opc_ua_client_waiting(
    fieldrig_master: MasterRigMaker, tmp_path: Path
) -> None:
    """Its server answers for it after two seconds; the client's own watchdog waits for one."""
    from asyncua import Client, ua

    (tmp_path / "count.st").write_text("PROGRAM Main VAR n : DINT; END_VAR n := n + 1; END_PROGRAM")
    device = {"kind": "max4", "links": {"opcua": "ua"}, "program": [str(tmp_path / "count.st")], "autostart": True}
    buses = {"ua": {"kind": "opcua.server", "listen": "127.0.0.1:14857"}}
    rig = fieldrig_master({"buses": buses, "devices": {"first": device, "second": device}})
    heard: list[tuple[int, float]] = []

    class Handler:
        def datachange_notification(self, node: Any, _value: Any, _data: Any) -> None:
            heard.append((node.nodeid.NamespaceIndex, time.monotonic()))

    async def main() -> None:
        async with Client("opc.tcp://127.0.0.1:14857") as client:
            nodes = [client.get_node(f"ns={index};s=Main.n") for index in (2, 3)]
            await (await client.create_subscription(100, Handler())).subscribe_data_change(nodes)
            await asyncio.sleep(1)
            rig.add_fault("ua", {"what": "drop", "device": "first", "duration_ms": 3000})
            asked_s = time.monotonic()
            reads = asyncio.create_task(client.read_attributes(nodes, ua.AttributeIds.Value))
            await asyncio.sleep(0.05)
            await client.nodes.server_state.read_value()
            assert time.monotonic() - asked_s < 0.2
            assert [value.StatusCode.name for value in await reads] == ["BadNoCommunication", "Good"]
            assert time.monotonic() - asked_s < 2.1
            assert sum(index == 3 and asked_s < when_s < asked_s + 2 for index, when_s in heard) > 15
            await asyncio.sleep(4)
            assert heard[-1][1] > asked_s + 5

    time.sleep(2)
    asyncio.run(main())
