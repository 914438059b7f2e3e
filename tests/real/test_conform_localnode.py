"""The conformance suite against python canopen's LocalNode, which joins a running hub by the Lawicel protocol."""

import pytest
from conform_peers import check_local_node, conform, local_node
from running_rig import RunningRig

from fieldrig.testing import free_port

pytestmark = [pytest.mark.real, pytest.mark.timeout(300)]


def test_suite_finds_what_local_node_fails() -> None:
    """Connect by slcan, because python-can's client of socketcand knows no remote frames."""
    port = free_port()
    rig = f"time: real\nbuses:\n  can0: {{kind: can.hub, bitrate: 1000000, slcan: {{listen: 127.0.0.1:{port}}}}}\n"
    with RunningRig(rig, None) as running:
        running.until_ready()
        with local_node(interface="slcan", channel=f"socket://127.0.0.1:{port}"):
            report = conform("--bus", f"can.hub:{running.run}/can0", "--timeout-ms", 200)
    check_local_node(report)
