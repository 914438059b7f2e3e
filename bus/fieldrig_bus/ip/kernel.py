"""IP of a device's link ends in the kernel of this host, at a TUN device.

The device sends the packets of its link, and takes those of the kernel.  This port listens at the device's ports, only
for the peer of the link, and opens a channel to the device for each connection.  Only packets between the two ends of
the link pass, so a caller reaches nothing else of the host, and no other client reaches the device.
"""

import asyncio
import logging
from collections.abc import Callable, Sequence
from socket import socket
from typing import Final

from fieldrig.bus import Hub
from fieldrig.errors import BusError
from fieldrig_bus.ip.channel import Channel
from fieldrig_bus.ip.channels import Channels
from fieldrig_bus.ip.message import IpPacket, KernelOffered, LinkDown, LinkUp, Opened, RelayMessage
from fieldrig_bus.ip.tun import DEVICE, Tun, is_of_this_host
from fieldrig_bus.ip.tunnel import Tunnelled, held_connections
from fieldrig_bus.net import ServingPort, TcpServer

log = logging.getLogger(__name__)

KERNEL: Final = "ip:kernel"
"""The member that ends links in the kernel."""
REMEDY: Final = "run as root, give the container NET_ADMIN and /dev/net/tun, or set `ip: own`"
_HEADER: Final = 20
_SOURCE, _DESTINATION = slice(12, 16), slice(16, 20)


class KernelPort(ServingPort):
    def __init__(self, bus: str, *, is_required: bool) -> None:
        """If TUN is not allowed, devices end IP in their own stacks, or `open` raises BusError if it `is_required`."""
        self._bus, self._is_required = bus, is_required
        self._connections = held_connections(bus)
        self._channels = Channels()
        self._last_number = 0
        self._tun: Tun | None = None
        self._link: LinkUp | None = None
        self._servers: dict[int, TcpListener] = {}

    def servers(self) -> Sequence[TcpServer]:
        return (self._connections,)

    async def open(self, hub: Hub) -> None:
        try:
            self._tun = Tun()
        except OSError as cause:
            what = f"{self._bus}: IP cannot end in the kernel of this host: {DEVICE}: {cause.strerror}"
            if self._is_required:
                raise BusError(what, REMEDY) from cause
            log.warning("%s; it ends in the stack of the device (%s)", what, REMEDY)
            return
        self._hub, self._relay = hub, hub.join(KERNEL)
        asyncio.get_running_loop().add_reader(self._tun.fd, self._on_readable, self._tun)
        self._relay.on_receive(self._on_message)
        self._relay.send(KernelOffered())

    async def close(self) -> None:
        if self._tun is None:
            return
        self._end_link()
        connections = list(self._connections.connections)
        await asyncio.gather(*(connection.lost for connection in connections))
        asyncio.get_running_loop().remove_reader(self._tun.fd)
        self._tun.close()
        self._hub.leave(KERNEL)

    # ---- messages

    def _on_message(self, message: RelayMessage) -> None:
        match message:
            case LinkUp():
                self._on_link(message)
            case LinkDown():
                self._end_link()
            case IpPacket():
                self._on_packet(message.data)
            case _:
                self._channels.take(message)

    def _on_link(self, link: LinkUp) -> None:
        assert self._tun is not None, "messages come only to an open port"
        before, self._link = self._link, link
        try:
            if before is None or (before.address, before.peer, before.mtu) != (link.address, link.peer, link.mtu):
                self._begin_link(self._tun, link)
            for port in set(link.ports) - self._servers.keys():
                self._servers[port] = TcpListener(self._tun.listener(link.address, port), port, self._new)
        except OSError as cause:
            log.warning("%s: IP of %s cannot end in the kernel: %s", self._bus, link.device, cause)
            self._end_link()
            self._relay.send(LinkDown(link.device, True, str(cause)))

    def _begin_link(self, tun: Tun, link: LinkUp) -> None:
        self._end_link()
        self._link = link
        for address in (link.address, link.peer):
            if is_of_this_host(address):
                raise OSError(f"another network device of this host has the address {address}")
        tun.set_up(link.address, link.peer, link.mtu)
        log.info("%s: IP of %s ends at the network device %s", self._bus, link.device, tun.name)

    def _end_link(self) -> None:
        self._link = None
        for server in self._servers.values():
            server.close()
        self._servers.clear()
        for connection in list(self._connections.connections):
            connection.transport.abort()
        if self._tun is not None:
            self._tun.set_down()

    # ---- packets

    def _on_packet(self, packet: bytes) -> None:
        """Pass a packet from the peer to the kernel."""
        link, tun = self._link, self._tun
        if link is None or tun is None or not _is_between(packet, link.peer.packed, link.address.packed):
            return
        try:
            tun.write(packet)
        except OSError as cause:
            log.debug("a packet was dropped: %s", cause)

    def _on_readable(self, tun: Tun) -> None:
        """Pass what the kernel sends to the peer, and drop everything else, such as its IPv6."""
        packet, link = tun.read(), self._link
        if packet and link is not None and _is_between(packet, link.address.packed, link.peer.packed):
            self._relay.send(IpPacket(link.device, True, packet))

    # ---- connections

    def _new(self, port: int) -> Tunnelled:
        key = KERNEL, self._last_number + 1
        self._last_number = key[1]
        channel = Channel(*key, False, self._relay.send)

        def begin() -> Channel:
            client = client_end.transport.get_extra_info("peername")
            if self._link is None or client[0] != str(self._link.peer):
                raise ConnectionError(f"it is at {client[0]}, and not at the other end of the link")
            client_end.enter(client[0])
            self._channels.add(key, channel)
            channel.pause()  # the device may answer at once
            self._relay.send(Opened(*key, port))
            return channel

        client_end = Tunnelled(self._connections, begin, lambda: self._channels.forget_if_over(channel, key))
        return client_end


class TcpListener:
    """Accepts connections at a socket that listens already, so none is refused before the loop knows it."""

    def __init__(self, listener: socket, port: int, make: Callable[[int], asyncio.BaseProtocol]) -> None:
        self._listener = listener
        self._server: asyncio.Server | None = None
        self._task = asyncio.get_running_loop().create_task(self._serve(lambda: make(port)))

    async def _serve(self, make: Callable[[], asyncio.BaseProtocol]) -> None:
        self._server = await asyncio.get_running_loop().create_server(make, sock=self._listener)

    def close(self) -> None:
        self._task.cancel()
        if self._server is not None:
            self._server.close()
        self._listener.close()


def _is_between(packet: bytes, source: bytes, destination: bytes) -> bool:
    is_ipv4 = len(packet) >= _HEADER and packet[0] >> 4 == 4
    return is_ipv4 and packet[_SOURCE] == source and packet[_DESTINATION] == destination
