"""A CANopen master that shares no line with ours or with python's: npm's `canopen`, on the kernel's CAN."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from conform_peers import NODE_ID
from running_rig import RunningRig
from vcan_rig import IO_ON_VCAN

pytestmark = [pytest.mark.real, pytest.mark.vcan]

MASTER = Path(__file__).parent / "node" / "master.js"


def test_npm_master_reads_starts_and_drives_the_io_node() -> None:
    node = shutil.which("node")
    if node is None or not (MASTER.parent / "node_modules").is_dir():
        pytest.skip("npm's canopen is not installed: npm ci in tests/real/node")
    with RunningRig(IO_ON_VCAN, None) as rig:
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
