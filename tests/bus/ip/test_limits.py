"""Connections between a device with a TCP/IP stack and this host: as many as the limits allow, with a figure."""

import asyncio
import os
import socket
from collections.abc import Callable
from contextlib import closing
from ipaddress import IPv4Address
from pathlib import Path

import pytest
from in_loop import in_loop
from patience import PATIENCE_S
from strangers import hub_of

from fieldrig.hub.hub import LocalHub
from fieldrig_bus.ip import kernel
from fieldrig_bus.ip.message import Closed, LinkUp, Opened, RelayMessage

pytestmark = pytest.mark.system

OF_A_PEER, OF_ALL = 48, 64


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not condition():
            await asyncio.sleep(0.005)


def over(hub: LocalHub) -> float:
    """Return how many connections were refused because their peer has too many."""
    return sum((port.statistics().get("connections over the limit of a peer", 0.0) for port in hub._ports), 0.0)


@in_loop
async def test_one_device_opens_so_many_connections_to_a_listener_of_the_host_and_others_still_get_one(
    tmp_path: Path,
) -> None:
    host: list[tuple[asyncio.StreamReader, asyncio.StreamWriter]] = []
    server = await asyncio.start_server(lambda *ends: host.append(ends), "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    async with hub_of("ip.relay", tmp_path, services={502: f"127.0.0.1:{port}"}) as hub:
        heard: list[RelayMessage] = []
        links = {name: hub.join(name) for name in ("plc", "other")}
        links["plc"].on_receive(heard.append)
        for number in range(200):
            links["plc"].send(Opened("plc", number, 502))
        await until(lambda: len(host) == OF_A_PEER and len(_refused(heard)) == 200 - OF_A_PEER)
        assert over(hub) == 200 - OF_A_PEER
        for number in range(OF_ALL - OF_A_PEER):
            links["other"].send(Opened("other", number, 502))
        await until(lambda: len(host) == OF_ALL)
        for number in range(OF_A_PEER):
            links["plc"].send(Closed("plc", number, False, "over"))
        await until(lambda: all(reader.at_eof() for reader, _ in host[:OF_A_PEER]))
        links["plc"].send(Opened("plc", 1000, 502))
        await until(lambda: len(host) == OF_ALL + 1)
    for _, writer in host:
        writer.close()
    server.close()


@in_loop
async def test_a_connection_that_the_listener_refuses_takes_no_place(tmp_path: Path) -> None:
    with closing(socket.create_server(("127.0.0.1", 0))) as taken:
        port = taken.getsockname()[1]
    async with hub_of("ip.relay", tmp_path, services={502: f"127.0.0.1:{port}"}) as hub:
        heard: list[RelayMessage] = []
        link = hub.join("plc")
        link.on_receive(heard.append)
        for round_ in range(3):
            for number in range(OF_A_PEER):
                link.send(Opened("plc", round_ * 100 + number, 502))
            await until(lambda: len(_refused(heard)) == OF_A_PEER)
            heard.clear()
        assert over(hub) == 0


def _refused(heard: list[RelayMessage]) -> list[RelayMessage]:
    return [message for message in heard if isinstance(message, Closed)]


class _Tun:
    """A TUN device without packets; the test connects by loopback instead of its peer."""

    name = "tun0"

    def __init__(self) -> None:
        self.fd, self._other = os.pipe()
        self.ports: dict[int, int] = {}

    def listener(self, address: IPv4Address, port: int) -> socket.socket:
        found = socket.create_server((str(address), 0))
        found.setblocking(False)
        self.ports[port] = found.getsockname()[1]
        return found

    def set_up(self, *_: object) -> None:
        """Nothing to set."""

    def set_down(self) -> None:
        """Nothing to reset."""

    def close(self) -> None:
        os.close(self.fd)
        os.close(self._other)


@in_loop
async def test_the_caller_of_a_link_opens_so_many_connections_to_the_device(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tun = _Tun()
    monkeypatch.setattr(kernel, "Tun", lambda: tun)
    monkeypatch.setattr(kernel, "is_of_this_host", lambda _address: False)
    async with hub_of("ip.relay", tmp_path, ip="kernel") as hub:
        heard: list[RelayMessage] = []
        plc = hub.join("plc")
        plc.on_receive(heard.append)
        plc.send(LinkUp("plc", IPv4Address("127.0.0.1"), IPv4Address("127.0.0.2"), 1500, (80,)))
        await until(lambda: 80 in tun.ports)
        callers = []
        for _ in range(100):
            caller = socket.socket()
            caller.bind(("127.0.0.2", 0))
            caller.setblocking(False)
            caller.connect_ex(("127.0.0.1", tun.ports[80]))
            callers.append(caller)
        await until(lambda: over(hub) == 100 - OF_A_PEER)
        assert sum(isinstance(message, Opened) for message in heard) == OF_A_PEER
        for caller in callers:
            caller.close()
