"""`fieldrig conform` on a rig that runs, by each of the ways to its bus."""

import subprocess
from collections.abc import Iterator

import pytest
from canopen_bench import IO32
from conform_peers import NODE_ID, conform
from patience import PATIENCE_S
from running_rig import RunningRig

from fieldrig.real.live_rig import FIELDRIG
from fieldrig.testing import free_port

pytestmark = pytest.mark.system

DEVICE = f"{{kind: canopen.node, node_id: {NODE_ID}, eds: {IO32}, links: {{can: can0}}}}"
CASES = ("--only", "SDO", "--only", "Emergency", "--only", "State")


@pytest.fixture(scope="module")
def slcan() -> int:
    return free_port()


@pytest.fixture(scope="module")
def running(slcan: int) -> Iterator[RunningRig]:
    rig = f"""
time: real
buses:
  can0: {{kind: can.hub, bitrate: 1000000, attach: "127.0.0.1:{free_port()}", slcan: {{listen: "127.0.0.1:{slcan}"}}}}
devices:
  io: {DEVICE}
"""
    with RunningRig(rig, None) as running:
        yield running.until_ready()


def test_by_the_rig_file(running: RunningRig) -> None:
    report = running.json("conform", "--rig", str(running.file), "--bus", "can0", "--node", str(NODE_ID), *CASES)
    assert (report["failed"], report["bus"]) == (0, "can0 of lab")


def test_by_the_run_folder(running: RunningRig) -> None:
    report = conform("--bus", f"can.hub:{running.run}/can0", *CASES)
    assert (report["failed"], report["passed"]) == (0, 39)


def test_by_python_can(running: RunningRig, slcan: int) -> None:
    report = conform("--bus", f"python-can:interface=slcan,channel=socket://127.0.0.1:{slcan}", *CASES)
    assert (report["failed"], report["passed"]) == (0, 39)


def test_hub_that_is_not_there_is_named(running: RunningRig) -> None:
    done = running.tool("conform", "--bus", "can.hub:run/other/can0", "--node", "5", "--eds", str(IO32))
    assert done.returncode == 3
    assert "start the process that runs this bus first" in done.stderr


def test_rig_that_ends_meanwhile_is_reported() -> None:
    rig = f"time: real\nbuses:\n  can0: {{kind: can.hub}}\ndevices:\n  io: {DEVICE}\n"
    with RunningRig(rig, None) as running:
        running.until_ready()
        command = [*FIELDRIG, "conform", "--rig", str(running.file), "--bus", "can0", "--node", str(NODE_ID)]
        with subprocess.Popen(
            command, cwd=running.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as peer:
            assert peer.stdout is not None
            assert peer.stderr is not None
            peer.stdout.readline()
            running.end()
            assert "the hub is gone" in peer.stderr.read()
            assert peer.wait(PATIENCE_S) == 3
