"""npm's `canopen`, unchanged, at drives with personalities, as the table of drive-personalities.md says."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from running_rig import RunningRig

from fieldrig.testing import free_port

pytestmark = [pytest.mark.real, pytest.mark.timeout(400)]

MASTER = Path(__file__).parent / "node" / "drive.js"
RIG = """
time: real
buses:
  can0: {{kind: can.hub, bitrate: 1000000, socketcand: "127.0.0.1:{port}"}}
devices:
  axis: {{kind: cia402.drive, node_id: 3, links: {{can: can0}}, personality: {name}, behaviour: {{boot_up_ms: 0}}}}
"""


@pytest.mark.parametrize(
    ("name", "moved", "error"),
    [
        ("own-units", 0, ""),
        ("mains-inverter", None, "Invalid value for download parameter [0x6060]"),
        ("robot-joint", None, "SDO protocol timed out [0x1000]"),
    ],
)
def test_npm_s_canopen_at_a_drive_that_differs(name: str, moved: int | None, error: str) -> None:
    """607Dh 0/0 allows position 0 only, an inverter has no profile position, and the first SDO request is lost."""
    node = shutil.which("node")
    if node is None or not (MASTER.parent / "node_modules").is_dir():
        pytest.skip("npm's canopen is not installed: npm ci in tests/real/node")
    port = free_port()
    with RunningRig(RIG.format(name=name, port=port), None) as rig:
        rig.until_ready()
        done = subprocess.run(
            [node, MASTER, str(port), "can0", "3"], capture_output=True, text=True, timeout=90, check=False
        )
    assert error in done.stderr
    assert (json.loads(done.stdout)["moved"] if done.returncode == 0 else None) == moved
