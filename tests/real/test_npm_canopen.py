"""A CANopen master that shares no line with ours or with python's: npm's `canopen`, on the kernel's CAN."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from running_rig import RunningRig

pytestmark = [pytest.mark.real, pytest.mark.vcan]

MASTER = Path(__file__).parent / "node" / "master.js"
EDS = Path(__file__).parents[2] / "configs" / "eds" / "io32.eds"
NODE_ID = 5

RIG = f"""
time: real
start_timeout_s: 60
buses:
  can0: {{kind: can.socketcan, channel: vcan0}}
devices:
  io: {{kind: canopen.node, node_id: {NODE_ID}, eds: {EDS}, links: {{can: can0}}}}
"""


def test_npm_master_reads_starts_and_drives_the_io_node() -> None:
    node = shutil.which("node")
    if node is None or not (MASTER.parent / "node_modules").is_dir():
        pytest.skip("npm's canopen is not installed: npm ci in tests/real/node")
    with RunningRig(RIG, None) as rig:
        rig.until_ready()
        done = subprocess.run(
            [node, MASTER, "vcan0", str(NODE_ID)], capture_output=True, text=True, timeout=60, check=False
        )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {
        "deviceType": 0x000F0191,  # CiA 401: digital and analog inputs and outputs
        "name": "IO32",
        "state": 5,  # operational
        "outputs": [0xA5, 0x5A, 0x00, 0xFF],
        "abort": 0x06020000,  # object does not exist
    }
