"""`ip.relay`: devices with a TCP/IP stack of their own reach the listeners of this host, and each other's services.

A device has no sockets.  It ends TCP connections in its stack, and opens a channel for each of them; in real time this
bus connects each channel to the listener that the rig file names for its port.  In virtual time there are no listeners;
there a device offers services on the bus itself.  In real time IP may end in the kernel of this host instead
(`kernel`).
"""

import asyncio
import logging
from collections.abc import Hashable, Sequence
from typing import Annotated, Any, ClassVar, Final, Literal

from pydantic import Field

from fieldrig.bus import Hub, ModelBus, Port, Time, words_of
from fieldrig.outside.addresses import split_address
from fieldrig.settings import Address
from fieldrig_bus.ip import codec
from fieldrig_bus.ip.channel import Channel
from fieldrig_bus.ip.channels import Channels
from fieldrig_bus.ip.faults import MODELS, RelayEffects, RelayFault
from fieldrig_bus.ip.kernel import KernelPort
from fieldrig_bus.ip.message import (
    MOST_PORTS,
    Closed,
    Consumed,
    Ended,
    IpPacket,
    KernelOffered,
    LinkDown,
    LinkUp,
    Offered,
    OnRelay,
    Opened,
    Portion,
    RelayMessage,
    check_sent,
)
from fieldrig_bus.ip.model import RelayModel
from fieldrig_bus.ip.tunnel import Tunnelled, held_connections
from fieldrig_bus.net import HubSettings, ServingPort, TcpServer, cancel

log = logging.getLogger(__name__)

SERVICES: Final = "ip:services"
"""The member that connects channels to the listeners of this host."""
CONNECT_S: Final = 5.0

PortNumber = Annotated[int, Field(ge=1, le=65_535)]


class RelaySettings(HubSettings):
    faults: list[RelayFault] = Field(default_factory=list, description="faults from the start")
    services: dict[PortNumber, Address] = Field(
        default={},
        max_length=MOST_PORTS,
        description="ports as devices see them, each with the host:port of the listener to which it leads",
    )
    ip: Literal["own", "auto", "kernel"] = Field(
        default="own",
        description=(
            "where IP of a link ends: own (in the stack of the device), kernel (of this host, by TUN), "
            "auto (kernel if this process may open TUN devices, or else own)"
        ),
    )


class IpRelay(ModelBus[OnRelay]):
    fault_models = MODELS
    about: ClassVar[str] = "TCP streams between devices with a TCP/IP stack and the listeners of this host"
    times: ClassVar[frozenset[Time]] = frozenset({"real", "virtual"})
    family: ClassVar[str] = "ip"
    notes_faults: ClassVar[bool] = True
    messages: ClassVar[tuple[type, ...]] = (
        *(Offered, Opened, Portion, Consumed, Ended, Closed),
        *(KernelOffered, LinkUp, LinkDown, IpPacket),
    )

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

    def effects(self) -> RelayEffects:
        return RelayEffects(self.settings.faults)

    @staticmethod
    def standing_of(message: OnRelay) -> Hashable:
        """An offer stands until its member makes another one, and a link until it is down."""
        if isinstance(message, LinkUp | LinkDown):
            return "link"
        return {Offered: "offer", KernelOffered: "kernel"}.get(type(message))

    def ports(self) -> Sequence[Port]:
        services, ip = self.settings.services, self.settings.ip
        relay = (RelayPort(self.name, services),) if services else ()
        kernel = () if ip == "own" else (KernelPort(self.name, is_required=ip == "kernel"),)
        return *relay, *kernel


class RelayPort(ServingPort):
    """Connects each channel to a listener of this host."""

    def __init__(self, bus: str, services: dict[int, str]) -> None:
        self._services = services
        self._sockets = held_connections(bus)
        self._channels = Channels()
        self._tasks: set[asyncio.Task[None]] = set()

    def servers(self) -> Sequence[TcpServer]:
        return (self._sockets,)

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
        if isinstance(message, Opened):
            self._open(message)
        else:
            self._channels.take(message)

    def _open(self, message: Opened) -> None:
        key = message.opener, message.number
        channel = Channel(*key, True, self._link.send)
        channel.pause()  # until the listener is connected
        self._channels.add(key, channel)
        way = Tunnelled(self._sockets, lambda: _open(channel), lambda: self._channels.forget_if_over(channel, key))
        try:
            way.enter(message.opener)
        except ConnectionError:  # the door has logged it
            self._give_up(channel, key)
            return
        task = asyncio.get_running_loop().create_task(self._connect(way, channel, self._services[message.port], key))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _connect(self, way: Tunnelled, channel: Channel, address: str, key: tuple[str, int]) -> None:
        host, port = split_address(address)
        try:
            async with asyncio.timeout(CONNECT_S):
                await asyncio.get_running_loop().create_connection(lambda: way, host, port)
        except OSError as cause:  # includes TimeoutError
            log.debug("%s cannot be reached: %s", address, cause)
            self._sockets.door.leave(way)
            self._give_up(channel, key)

    def _give_up(self, channel: Channel, key: tuple[str, int]) -> None:
        channel.abort()
        self._channels.forget_if_over(channel, key)


def _open(channel: Channel) -> Channel:
    """Return the channel.  ConnectionError if its other end has given it up in the meantime."""
    if channel.is_over:
        raise ConnectionError("the channel is closed")
    return channel
