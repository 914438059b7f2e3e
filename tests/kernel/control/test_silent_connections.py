"""Connections at the control endpoint that say nothing are counted, those of tools are not."""

import socket
import sys
import time
from contextlib import ExitStack, closing
from pathlib import Path

import pytest
import zenoh
from in_loop import in_loop

from fieldrig.config.rig_file import load
from fieldrig.control import endpoint
from fieldrig.control.messages import Control
from fieldrig.control.rig_status import rig_status
from fieldrig.control.silent_connections import silent_connections

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells"),
]
CONFIGS = Path(__file__).parents[3] / "configs"


def free_port() -> int:
    with closing(socket.create_server(("127.0.0.1", 0))) as taken:
        return int(taken.getsockname()[1])


def counts(session: zenoh.Session, place: str, expected: int) -> bool:
    """Return whether the figure becomes this one: Zenoh shows a tool a moment after the tool is connected."""
    end_s = time.monotonic() + 10
    while silent_connections(session, place) != expected:
        if time.monotonic() > end_s:
            return False
        time.sleep(0.01)
    return True


def test_tcp_connections_without_a_word_are_counted() -> None:
    port = free_port()
    place = f"tcp/127.0.0.1:{port}"
    with ExitStack() as stack:
        session = stack.enter_context(closing(endpoint.listen(place)))
        assert silent_connections(session, place) == 0
        stack.enter_context(closing(endpoint.connect(place)))
        for _ in range(5):
            stack.enter_context(closing(socket.create_connection(("127.0.0.1", port))))
        assert counts(session, place, 5)


def test_connections_to_a_unix_socket_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "control"
    place = f"unixsock-stream/{path}"
    with ExitStack() as stack:
        session = stack.enter_context(closing(endpoint.listen(place)))
        stack.enter_context(closing(endpoint.connect(place)))
        for _ in range(3):
            client = stack.enter_context(closing(socket.socket(socket.AF_UNIX)))
            client.connect(str(path))
        assert counts(session, place, 3)


@pytest.mark.parametrize("mode", ["router", "peer"])
def test_connections_that_say_nothing_keep_no_process_out(mode: str) -> None:
    """The endpoint of a rig is a router; a ring over Zenoh listens as a peer."""
    port = free_port()
    place = f"tcp/127.0.0.1:{port}"
    with ExitStack() as stack:
        stack.enter_context(closing(endpoint.open_session({"mode": mode, "listen/endpoints": [place]})))
        for _ in range(300):
            stack.enter_context(closing(socket.create_connection(("127.0.0.1", port))))
        stack.enter_context(closing(endpoint.connect(place, patience_s=4)))


@in_loop
async def test_status_has_the_figure() -> None:
    port = free_port()
    config = load(CONFIGS / "modems.yaml", ["time=virtual", f"control=tcp/127.0.0.1:{port}"])
    control = Control(endpoint.listen(config.control), config.name)
    try:
        assert "silent_connections" not in rig_status(config, control, 0.0, lambda device: device.process)
        with closing(socket.create_connection(("127.0.0.1", port))):
            assert rig_status(config, control, 0.0, lambda device: device.process)["silent_connections"] == 1
    finally:
        await control.close()
