"""`fieldrig conform` as a process, and python canopen's LocalNode for it, with what it is known to fail."""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from canopen_bench import IO32

from fieldrig.real.live_rig import FIELDRIG

NODE_ID = 5
PATIENCE_S = 400

# canopen 2.4.1, from the EDS of the I/O module.  State 02 comes and goes: its heartbeat after a reset looks like a
# boot-up message.
LOCAL_NODE_FAILS = {
    "SDO": {"2.5", "2.10", "2.11", "2.13", "2.19", "2.22", "2.23", "2.26", "2.27", "2.29"},
    "PDO": {
        "3.3", "3.5", "3.6", "3.8", "3.22", "3.23", "3.24", "3.25", "3.26", "3.28", "3.29", "3.31", "3.32",
    },
    "OD": {"4.1", "4.2", "4.5", "4.6", "4.7", "4.8"},
    "Emergency": {"5.3", "5.4", "5.5", "5.6"},
    "Synchronization": {"6.2", "6.3", "6.5", "6.6", "6.7", "6.9", "6.10"},
    "Guarding": {"7.2", "7.3", "7.6"},
    "Heartbeat": {"7.104", "7.106"},
    "Heartbeat versus guarding": {"7.203", "7.204", "7.205", "7.206", "7.207"},
    "Testing other": {"8.1", "8.2", "8.3", "8.4", "8.5", "8.6", "8.7", "8.8", "8.9", "8.10"},
    "State": {"9.1", "9.3", "9.4"},
    "Transition": {"10.1"},
}  # fmt: skip
UNSTABLE = {"9.2"}
LOCAL_NODE_LACKS = {"2.20", "2.21", "2.24", "2.25", "2.30"}
"""Block download, SDO clients."""


def conform(*arguments: object) -> dict[str, Any]:
    """The report of a run on node 5 as the I/O module."""
    command = [*FIELDRIG, "conform", "--node", str(NODE_ID), "--eds", str(IO32), "--json", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert done.returncode in (0, 8), done.stderr
    report: dict[str, Any] = json.loads(done.stdout)
    return report


def verdicts(report: dict[str, Any], verdict: str) -> set[str]:
    return {case["number"] for case in report["cases"] if case["verdict"] == verdict}


@contextmanager
def local_node(**bus: str) -> Iterator[None]:
    """LocalNode on a bus of python-can, as node 5."""
    script = str(Path(__file__).parent / "local_node.py")
    command = [sys.executable, script, str(IO32), str(NODE_ID), *(f"{key}={value}" for key, value in bus.items())]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as peer:
        assert peer.stdout is not None
        assert peer.stdin is not None
        assert peer.stdout.readline() == "ready\n"
        try:
            yield
        finally:
            peer.stdin.close()
            peer.wait(10)


def check_local_node(report: dict[str, Any]) -> None:
    """The failures that are known are found, and no other."""
    known = set().union(*LOCAL_NODE_FAILS.values())
    failed = verdicts(report, "failed") - UNSTABLE
    assert failed == known, f"not known: {failed - known}; not found: {known - failed}"
    assert verdicts(report, "not applicable") == LOCAL_NODE_LACKS
