"""`ip.relay`: devices with a TCP/IP stack of their own reach the listeners of this host, and each other's services.

A device has no sockets.  It ends TCP connections in its stack, and opens a channel for each of them; in real time this
bus connects each channel to the listener that the rig file names for its port.  In virtual time there are no listeners;
there a device offers services on the bus itself.
"""

import asyncio
import logging
from collections.abc import Hashable, Sequence
from typing import Annotated, Any, ClassVar, Final

from pydantic import Field

from fieldrig.bus import Hub, ModelBus, Port, Time, words_of
from fieldrig.net import split_address
from fieldrig_bus.ip import codec
from fieldrig_bus.ip.channel import Channel
from fieldrig_bus.ip.message import (
    MOST_PORTS,
    Closed,
    Consumed,
    Ended,
    Offered,
    Opened,
    Portion,
    RelayMessage,
    check_sent,
)
from fieldrig_bus.ip.model import RelayModel
from fieldrig_bus.ip.tunnel import Tunnelled
from fieldrig_bus.net import Address, HubSettings, TcpServer, cancel

log = logging.getLogger(__name__)

SERVICES: Final = "ip:services"
"""The member that connects channels to the listeners of this host."""
CONNECT_S: Final = 5.0

PortNumber = Annotated[int, Field(ge=1, le=65_535)]


class RelaySettings(HubSettings):
    services: dict[PortNumber, Address] = Field(
        default={},
        max_length=MOST_PORTS,
        description="ports as devices see them, each with the host:port of the listener to which it leads",
    )


class IpRelay(ModelBus[RelayMessage]):
    about: ClassVar[str] = "TCP streams between devices with a TCP/IP stack and the listeners of this host"
    times: ClassVar[frozenset[Time]] = frozenset({"real", "virtual"})
    family: ClassVar[str] = "ip"
    messages: ClassVar[tuple[type, ...]] = (Offered, Opened, Portion, Consumed, Ended, Closed)

    encode = staticmethod(codec.encode)
    decode = staticmethod(codec.decode)
    show = staticmethod(codec.show)
    check = staticmethod(check_sent)

    def __init__(self, name: str, settings: RelaySettings) -> None:
        super().__init__(name, settings)

    def check_interest(self, interest: Any) -> None:
        """Raise ValueError or TypeError for any interest, because each end receives what is meant for it."""
        if any(True for _ in words_of(interest)):
            raise ValueError("expected no interest, because each end receives what is meant for it")

    def model(self) -> RelayModel:
        return RelayModel()

    @staticmethod
    def standing_of(message: RelayMessage) -> Hashable:
        """An offer stands until its member makes another one."""
        return "offer" if isinstance(message, Offered) else None

    def ports(self) -> Sequence[Port]:
        services = self.settings.services
        return (RelayPort(self.name, services),) if services else ()


class RelayPort(Port):
    """Connects each channel to a listener of this host."""

    def __init__(self, bus: str, services: dict[int, str]) -> None:
        self._services = services
        self._sockets = TcpServer(bus, lambda _: _never())  # holds the connections; never opened
        self._channels: dict[tuple[str, int], Channel] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    async def open(self, hub: Hub) -> None:
        self._hub, self._link = hub, hub.join(SERVICES)
        self._link.on_receive(self._on_message)
        self._link.send(Offered(tuple(self._services)))

    async def close(self) -> None:
        for task in list(self._tasks):
            await cancel(task)
        connections = list(self._sockets.connections)
        for connection in connections:
            connection.transport.abort()
        await asyncio.gather(*(connection.lost for connection in connections))
        self._hub.leave(SERVICES)

    def _on_message(self, message: RelayMessage) -> None:
        match message:
            case Opened():
                self._open(message)
            case Portion() | Consumed() | Ended() | Closed():
                key = message.opener, message.number
                channel = self._channels.get(key)
                if channel is not None:
                    channel.take(message)
                    self._forget_if_over(key, channel)

    def _open(self, message: Opened) -> None:
        key = message.opener, message.number
        channel = Channel(*key, True, self._link.send)
        channel.pause()  # until the listener is connected
        self._channels[key] = channel
        task = asyncio.get_running_loop().create_task(self._connect(channel, self._services[message.port], key))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _connect(self, channel: Channel, address: str, key: tuple[str, int]) -> None:
        host, port = split_address(address)
        try:
            async with asyncio.timeout(CONNECT_S):
                await asyncio.get_running_loop().create_connection(
                    lambda: Tunnelled(
                        self._sockets, lambda: _open(channel), lambda: self._forget_if_over(key, channel)
                    ),
                    host,
                    port,
                )
        except OSError as cause:  # includes TimeoutError
            log.debug("%s can't be reached: %s", address, cause)
            channel.abort()
            self._forget_if_over(key, channel)
        else:
            channel.resume()

    def _forget_if_over(self, key: tuple[str, int], channel: Channel) -> None:
        if channel.is_over and self._channels.get(key) is channel:
            del self._channels[key]


def _open(channel: Channel) -> Channel:
    """Return the channel.  ConnectionError if its other end has given it up in the meantime."""
    if channel.is_over:
        raise ConnectionError("the channel is closed")
    return channel


def _never() -> Any:
    raise AssertionError("this server never listens")
