"""An OPC UA client that shares no line with ours: npm's `node-opcua`, with a running MAx-4."""

import json
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from running_rig import RunningRig, until

from fieldrig.testing import free_port

pytestmark = pytest.mark.real

CLIENT = Path(__file__).parent / "node" / "opcua.js"
TOKEN = "a secret of this test"
RIG = """
time: real
buses:
  open: {{kind: opcua.server, listen: "127.0.0.1:{open}"}}
  secured:
    kind: opcua.server
    listen: "127.0.0.1:{secured}"
    security: sign_and_encrypt
    users: {{engineer: write, visitor: read}}
devices:
  max4: {{kind: max4, links: {{opcua: open}}, program: [count.st], autostart: true}}
  safe: {{kind: max4, links: {{opcua: secured}}, program: [count.st], autostart: true}}
"""
PROGRAM = """
PROGRAM PLC_PRG
VAR
    count : DINT;
    setpoint : REAL;
    small : INT(0..10);
    table : ARRAY[1..3] OF INT := 4, 5, 6;
END_VAR
count := count + 1;
END_PROGRAM
"""


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[RunningRig, dict[str, int]]]:
    folder, ports = tmp_path_factory.mktemp("opcua"), {"open": free_port(), "secured": free_port()}
    (folder / "count.st").write_text(PROGRAM)
    file = folder / "lab.yaml"
    file.write_text(RIG.format(**ports))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FIELDRIG_TOKEN", TOKEN)
        yield from _running(file, ports)


def _running(file: Path, ports: dict[str, int]) -> Iterator[tuple[RunningRig, dict[str, int]]]:
    with RunningRig(file, None) as running:
        running.until_ready()
        until(lambda: running.value("max4/program") == running.value("safe/program") == "running")
        yield running, ports


def client(rig: tuple[RunningRig, dict[str, int]], bus: str, folder: Path, *arguments: str) -> dict[str, Any]:
    """Return the results of the client."""
    node = shutil.which("node")
    if node is None or not (CLIENT.parent / "node_modules" / "node-opcua-client").is_dir():
        pytest.skip("npm's node-opcua-client is not installed: npm ci in tests/real/node")
    url = f"opc.tcp://127.0.0.1:{rig[1][bus]}"
    done = subprocess.run(
        [node, CLIENT, url, folder, *arguments], capture_output=True, text=True, timeout=110, check=False
    )
    assert done.returncode == 0, done.stderr + done.stdout
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


@pytest.mark.manual("PD-284")
def test_node_opcua_browses_reads_writes_subscribes_calls_and_forces(
    rig: tuple[RunningRig, dict[str, int]], tmp_path: Path
) -> None:
    found = client(rig, "open", tmp_path)
    methods = {"start", "stop", "reset", "quit", "force", "release", "forced"}
    assert {"PLC_PRG", "PacDriveM", *methods} <= set(found["device"])
    assert {"count", "setpoint", "small", "table"} <= set(found["program"])
    assert {key: found[key] for key in found if key not in ("device", "program", "user", "policy")} == {
        "path": "ns=2;s=PLC_PRG.count",
        "type": "Int32",
        "timestamp": True,
        "written": "Good",
        "read": 2.5,
        "array": [4, 5, 6],
        "wrongType": "BadTypeMismatch",
        "outOfRange": "BadOutOfRange",
        "readOnly": "BadNotWritable",
        "unknown": "BadNodeIdUnknown",
        "stop": "Good",
        "values": [2.5, 3.5],
        "start": "Good",
        "counts": True,
        "forcing": {
            "arguments": [["Variable", "NodeId", True], ["Value", "Variant", True]],
            "refused": ["BadInvalidArgument", "Good", "BadTypeMismatch"],
            "force": "Good",
            "forced": ["ns=2;s=PLC_PRG.count"],
            "held": [1000, 1000, 1000],
            "release": "Good",
            "left": [],
            "counts": True,
        },
    }
    assert rig[0].ask("device/max4/debug", {"command": "forced"})["variables"] == []


@pytest.mark.parametrize(
    ("user", "password", "outcome"),
    [
        ("engineer", TOKEN, {"written": "Good", "forced": "Good"}),
        ("visitor", TOKEN, {"written": "BadUserAccessDenied", "forced": "BadUserAccessDenied"}),
        ("engineer", "wrong", {"refused": "BadUserAccessDenied"}),
    ],
)
def test_node_opcua_signs_and_encrypts_and_is_refused_without_the_password(
    rig: tuple[RunningRig, dict[str, int]], tmp_path: Path, user: str, password: str, outcome: dict[str, str]
) -> None:
    found = client(rig, "secured", tmp_path, user, password)
    policy = "http://opcfoundation.org/UA/SecurityPolicy#Basic256Sha256"
    assert found == {"user": user, "policy": policy, **outcome}


def test_the_secured_server_accepts_no_client_without_a_name(
    rig: tuple[RunningRig, dict[str, int]], tmp_path: Path
) -> None:
    found = client(rig, "secured", tmp_path)
    assert found.keys() == {"user", "policy", "refused"}, found
    assert "securityMode = None" in found["refused"]  # it offers no such endpoint
