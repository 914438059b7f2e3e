"""A unit that does not answer for a while: its masters reach it again, however often they have asked in vain."""

import socket
import time
from pathlib import Path
from typing import Any

import pytest
from modbus_bench import mbap

from fieldrig import Rig, from_dict, virtual_time
from fieldrig.testing import free_port

pytestmark = [pytest.mark.lean, pytest.mark.timeout(60), pytest.mark.long]
READ = bytes.fromhex("03 0000 0001")
ANSWER = bytes.fromhex("03 02 0007")
TABLE = "{holding_registers: [{address: 0, name: value, type: u16, initial: 7}]}"


def rig_of(folder: Path, port: int) -> dict[str, Any]:
    (folder / "table.yaml").write_text(TABLE)
    return {
        "time": "virtual",
        "buses": {"line": {"kind": "modbus.tcp", "listen": f"127.0.0.1:{port}"}},
        "devices": {
            "meter": {"kind": "modbus.device", "table": "table.yaml", "unit_id": 1, "links": {"modbus": "line"}}
        },
    }


@pytest.mark.parametrize("in_vain", [1, 8, 9, 16, 40])
def test_every_master_is_answered_after_the_silence(tmp_path: Path, in_vain: int) -> None:
    """After eight requests without an answer the unit was never reached again, by this master and by all others."""
    port = free_port()
    with Rig(from_dict(rig_of(tmp_path, port), tmp_path)) as rig, virtual_time(rig):
        rig.add_fault("meter", {"what": "silent", "duration_ms": 1000})
        with master(port) as first, master(port) as second:
            for number in range(in_vain):
                first.sendall(mbap(number, 1, READ))
            time.sleep(2)
            for number, one in ((98, second), (99, first)):
                one.sendall(mbap(number, 1, READ))
                until_answered(one, mbap(number, 1, ANSWER))


def master(port: int) -> socket.socket:
    return socket.create_connection(("127.0.0.1", port), timeout=30)


def until_answered(master: socket.socket, answer: bytes) -> None:
    heard = b""
    while not heard.endswith(answer):
        heard += master.recv(1000)
        assert heard, "the connection was closed"
