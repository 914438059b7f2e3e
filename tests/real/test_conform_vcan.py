"""The conformance suite on the kernel's CAN: our node, and python canopen's LocalNode."""

import pytest
from canopen_bench import IO32
from conform_peers import NODE_ID, check_local_node, conform, local_node, verdicts
from running_rig import RunningRig

pytestmark = [pytest.mark.real, pytest.mark.vcan, pytest.mark.timeout(400)]

RIG = f"""
time: real
start_timeout_s: 60
buses:
  can0: {{kind: can.socketcan, channel: vcan0}}
devices:
  io: {{kind: canopen.node, node_id: {NODE_ID}, eds: {IO32}, links: {{can: can0}}}}
"""


def test_io_node_passes() -> None:
    with RunningRig(RIG, None) as running:
        running.until_ready()
        report = conform("--bus", "can.socketcan:vcan0", "--alone")
    assert verdicts(report, "failed") == set()
    assert report["passed"] >= 115


def test_suite_finds_what_local_node_fails() -> None:
    with local_node(interface="socketcan", channel="vcan0"):
        report = conform("--bus", "can.socketcan:vcan0")
    check_local_node(report)
