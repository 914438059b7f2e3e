"""The lab on UDP multicast with python-can's `udp_multicast`, in a network that nothing leaves."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.real

TESTS = Path(__file__).with_name("udp_lab.py")
NAMESPACE = ["unshare", "--map-root-user", "--net"]


def test_lab_on_udp_multicast() -> None:
    if shutil.which("unshare") is None or subprocess.run([*NAMESPACE, "true"], check=False).returncode != 0:
        pytest.skip("there are no network namespaces: python-can would join the group on the network card")
    pytest_line = '"$0" -m pytest -q -p no:cacheprovider "$1"'
    command = [
        *NAMESPACE,
        "sh",
        "-ec",
        f"ip link set lo up multicast on; exec {pytest_line}",
        sys.executable,
        str(TESTS),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=110, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
