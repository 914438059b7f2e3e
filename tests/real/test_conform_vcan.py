"""The conformance suite on the kernel's CAN: our node, and python canopen's LocalNode."""

import pytest
from conform_peers import check_local_node, conform, local_node, verdicts
from running_rig import RunningRig
from vcan_rig import IO_ON_VCAN

pytestmark = [pytest.mark.real, pytest.mark.vcan, pytest.mark.timeout(400)]


def test_io_node_passes() -> None:
    with RunningRig(IO_ON_VCAN, None) as running:
        running.until_ready()
        report = conform("--bus", "can.socketcan:vcan0", "--alone")
    assert verdicts(report, "failed") == set()
    assert report["passed"] >= 115


def test_suite_finds_what_local_node_fails() -> None:
    with local_node(interface="socketcan", channel="vcan0"):
        report = conform("--bus", "can.socketcan:vcan0")
    check_local_node(report)
