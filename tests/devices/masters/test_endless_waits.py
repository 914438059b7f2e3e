"""A wait that only the master itself could end fails at once, beside a rig that goes on by itself; others are kept."""

import asyncio
import socket
import threading
from collections.abc import Callable
from typing import Any

import can
import pytest

from fieldrig import Rig, S, from_dict, virtual_time
from fieldrig.master_time.errors import VirtualTimeError

pytestmark = [pytest.mark.lean, pytest.mark.long, pytest.mark.timeout(60)]
PORT = 29577
BEATING = {
    "kind": "cia402.drive", "node_id": 3, "links": {"can": "can0"}, "objects": {"1017:00": 1000},
}  # fmt: skip
RIG: dict[str, Any] = {
    "time": "virtual",
    "buses": {"can0": {"kind": "can.virtual", "bitrate": 1_000_000, "socketcand": f"127.0.0.1:{PORT}"}},
    "devices": {"axis": BEATING},
}


def wait_on_a_pair() -> None:
    near, far = socket.socketpair()
    with near, far:
        near.recv(1)


def wait_for_a_client() -> None:
    with socket.create_server(("127.0.0.1", 29578)) as server:
        server.accept()


def wait_for_a_peer_of_the_master() -> None:
    with socket.create_server(("127.0.0.1", 29579)) as server, socket.create_connection(("127.0.0.1", 29579)) as near:
        far, _ = server.accept()
        with far:
            near.recv(1)


def wait_in_an_event_loop() -> None:
    async def serve() -> None:
        async with await asyncio.start_server(lambda *_: None, "127.0.0.1", 29580) as server:
            await server.serve_forever()

    asyncio.run(serve())


def wait_after_a_connection() -> None:
    with socket.create_connection(("127.0.0.1", PORT)) as line:
        assert line.recv(100).startswith(b"< hi")
    wait_on_a_pair()


def wait_beside_another_thread() -> None:
    threading.Thread(target=wait_on_a_pair, daemon=True).start()
    threading.Event().wait()


@pytest.mark.parametrize(
    "wait",
    [
        wait_on_a_pair, wait_for_a_client, wait_for_a_peer_of_the_master, wait_in_an_event_loop,
        wait_after_a_connection, wait_beside_another_thread,
    ],
)  # fmt: skip
def test_a_wait_that_only_the_master_could_end_fails_at_once(wait: Callable[[], None]) -> None:
    with Rig(from_dict(RIG)) as rig:
        with pytest.raises(VirtualTimeError, match="nothing in the rig can wake one of them"), virtual_time(rig):
            wait()
        assert rig.now_ns <= 30 * S  # when the last timer of a port ends, which is one of the connection that was


def test_a_wait_for_a_port_of_the_rig_is_kept() -> None:
    with Rig(from_dict(RIG)) as rig, virtual_time(rig), socket.create_connection(("127.0.0.1", PORT)) as line:
        line.recv(100)
        for message in (b"< open can0 >", b"< rawmode >"):
            line.sendall(message)
            assert line.recv(100) == b"< ok >"
        assert line.recv(100).startswith(b"< frame 703 ")


def test_a_wait_at_an_end_of_a_bus_is_kept() -> None:
    """The boot-up message, and the first heartbeat a second later."""
    with Rig(from_dict(RIG)) as rig, virtual_time(rig), can.Bus(interface="fieldrig", channel="can0") as bus:
        beats = [bus.recv(), bus.recv()]
        assert [(beat.arbitration_id, beat.data.hex()) for beat in beats if beat] == [(0x703, "00"), (0x703, "7f")]
        assert rig.now_ns // S == 1
