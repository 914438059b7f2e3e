"""The TCP/IP stack opposite that of Linux, over a TUN device in a network namespace."""

import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

pytestmark = pytest.mark.real

PROGRAM = Path(__file__).parent.parent / "support" / "tun_kernel.py"
NAMESPACE = ["unshare", "--user", "--map-root-user", "--net"]


@cache
def obstacle() -> str | None:
    """Return why there is no TUN device here, or None."""
    try:
        found = subprocess.run(
            [*NAMESPACE, "ip", "tuntap", "add", "tun0", "mode", "tun"], capture_output=True, text=True
        )
    except FileNotFoundError as cause:
        return f"{cause.filename} is not installed: apt-get install util-linux"
    return None if found.returncode == 0 else f"no TUN device in a namespace of its own: {found.stderr.strip()}"


def scene(name: str, lost: float = 0.0) -> list[str]:
    if (reason := obstacle()) is not None:
        pytest.skip(reason)
    command = [*NAMESPACE, sys.executable, str(PROGRAM), name, str(lost)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=110)
    assert done.returncode == 0, done.stderr
    return sorted(done.stdout.splitlines())


@pytest.mark.parametrize("lost", [0.0, 0.02])
@pytest.mark.parametrize("name", ["download", "upload", "dial_out"])
def test_a_megabyte_arrives_whole(name: str, lost: float) -> None:
    assert scene(name, lost)[0] == "all of it"


def test_a_closed_port_refuses_on_both_sides() -> None:
    assert scene("refused") == ["the stack refuses", "was refused by the peer"]


def test_a_client_that_does_not_read_resets() -> None:
    assert scene("reset") == ["was reset by the peer"]


def test_a_user_that_pauses_slows_the_kernel_down() -> None:
    assert scene("slow_reader") == ["all of it"]


def test_the_kernel_accepts_the_answer_to_its_echo() -> None:
    assert scene("ping") == [repr(b"\x00\x07are you there")]
