"""The end of a block takes no virtual time, whatever the ports of the rig still wait for."""

import asyncio
import socket
import time
from typing import Any

import pytest

from fieldrig import Rig, S, from_dict, virtual_time
from fieldrig_bus.can.socketcand import SocketcandPort

pytestmark = [pytest.mark.lean, pytest.mark.long]

BUSES: dict[str, Any] = {"can0": {"kind": "can.virtual", "bitrate": 1_000_000, "socketcand": "127.0.0.1:29536"}}


@pytest.mark.parametrize("steps", [0, 3])
@pytest.mark.parametrize("wait_s", [0.0, 30.0, None])
def test_a_port_that_would_wait_when_it_closes(
    monkeypatch: pytest.MonkeyPatch, steps: int, wait_s: float | None
) -> None:
    """None waits for an event that never comes; before that, some steps of the event loop are no wait."""
    seen: list[str] = []

    async def close(port: SocketcandPort) -> None:
        for _ in range(steps):
            await asyncio.sleep(0)
        seen.append("begun")
        try:
            await (asyncio.Event().wait() if wait_s is None else asyncio.sleep(wait_s))
        finally:
            seen.append("over")
            await before(port)

    before = SocketcandPort.close
    monkeypatch.setattr(SocketcandPort, "close", close)
    with Rig(from_dict({"time": "virtual", "buses": BUSES, "devices": {}})) as rig:
        with virtual_time(rig), socket.create_connection(("127.0.0.1", 29536)) as sock:
            assert sock.recv(100) == b"< hi >"
            time.sleep(2)
        assert rig.now_ns == 2 * S
    assert seen == ["begun", "over"]


def test_a_fault_of_a_port_that_closes_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    async def close(port: SocketcandPort) -> None:
        await before(port)
        raise OSError("the pty is gone")

    before = SocketcandPort.close
    monkeypatch.setattr(SocketcandPort, "close", close)
    rig = Rig(from_dict({"time": "virtual", "buses": BUSES, "devices": {}}))
    with pytest.raises(OSError, match="the pty is gone"), rig, virtual_time(rig):
        time.sleep(1)
