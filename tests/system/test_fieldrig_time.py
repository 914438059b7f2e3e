"""One test of a master runs in virtual time, and in real time by a switch of pytest."""

import subprocess
import sys
from pathlib import Path

import pytest

from fieldrig.testing import free_port

pytestmark = pytest.mark.system
TABLE = Path(__file__).parents[2] / "configs" / "registers" / "pump-drive.yaml"
RIG = """\
time: real
buses:
  mb: {{kind: modbus.tcp, listen: "127.0.0.1:{port}"}}
  wires: {{kind: wires.hub}}
devices:
  drive: {{kind: modbus.device, unit_id: 1, table: {table}, links: {{modbus: [mb], wires: wires}}}}
"""
TEST = """\
import time
from pymodbus.client import ModbusTcpClient

def test_a_master(fieldrig_master):
    rig = fieldrig_master("rig.yaml")
    begin = time.monotonic()
    with ModbusTcpClient("127.0.0.1", port={port}) as client:
        client.write_register(0, 250)
        time.sleep(0.5)
        assert client.read_holding_registers(0).registers == [250]
    assert rig.get("drive/speed_set") == 25
    print("took", time.monotonic() - begin)
"""


@pytest.mark.parametrize("of_time", ["virtual", "real"])
def test_a_test_of_a_master_runs_in_both_times(tmp_path: Path, of_time: str) -> None:
    port = free_port()
    (tmp_path / "rig.yaml").write_text(RIG.format(port=port, table=TABLE))
    (tmp_path / "test_it.py").write_text(TEST.format(port=port))
    command = [sys.executable, "-m", "pytest", "-q", "-s", "-p", "no:cacheprovider", f"--fieldrig-time={of_time}"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stdout + done.stderr
    took_s = float(done.stdout.split("took ")[1].split()[0])
    assert took_s >= 0.5
    if of_time == "virtual":  # a client of pymodbus sleeps for some milliseconds
        assert took_s < 0.52
