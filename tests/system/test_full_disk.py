"""A disk without room: a small tmpfs in a mount namespace of its own, for each device that stores, and for a rig."""

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import full_disk
import pytest
from storing_devices import KINDS

pytestmark = pytest.mark.system

MOUNT = 'mount -t tmpfs -o size=1m,mode=0700 tmpfs "$0" && exec "$@"'


def on_a_small_disk(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["unshare", "--mount", "sh", "-c", MOUNT, str(folder), *command],
        env=os.environ | {"PYTHONPATH": str(Path(full_disk.__file__).parent)},
        capture_output=True,
        text=True,
        check=False,
    )


@cache
def can_mount(folder: Path) -> bool:
    try:
        return on_a_small_disk(folder, "true").returncode == 0
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("what", [*KINDS, "rig"])
def test_a_full_disk_is_refused_and_recovered_from(tmp_path_factory: pytest.TempPathFactory, what: str) -> None:
    folder = tmp_path_factory.mktemp("d")
    if not can_mount(tmp_path_factory.getbasetemp()):
        assert not (os.environ.get("CI") == "true" and os.geteuid() == 0), "root in CI cannot mount a tmpfs"
        pytest.skip("a tmpfs in a mount namespace of its own (unshare, as root)")
    done = on_a_small_disk(folder, sys.executable, full_disk.__file__, what, str(folder))
    assert done.returncode == 0, done.stdout + done.stderr
