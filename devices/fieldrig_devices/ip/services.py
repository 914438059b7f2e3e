"""The services behind a stack: its connections are carried over a relay to listeners outside, or to other devices."""

from collections.abc import Callable

from fieldrig.link import Link
from fieldrig_bus.ip.channel import Channel
from fieldrig_bus.ip.message import Closed, Consumed, Ended, Offered, Opened, Portion, RelayMessage
from fieldrig_bus.ip.stream import join
from fieldrig_devices.ip.stack import Stack
from fieldrig_devices.ip.tcp.connection import Connection


class RelayedServices:
    """Listens in a stack at all ports that the relay offers, and opens a channel for each connection."""

    def __init__(self, name: str, link: Link[RelayMessage], on_change: Callable[[], None]) -> None:
        """`name` is the device's.  `on_change` is called after messages; the stack is then to be advanced."""
        self._name, self._link, self._on_change = name, link, on_change
        self._stack: Stack | None = None
        self._ports: set[int] = set()
        self._channels: dict[int, Channel] = {}
        self._last_number = 0
        link.on_receive(self._on_message)

    def attach(self, stack: Stack | None) -> None:
        """Serve this stack from now on, instead of the one before; None without a link."""
        self._stack = stack
        self._listen()

    def _listen(self) -> None:
        if self._stack is not None:
            for port in self._ports:
                self._stack.listen(port, self._accept)

    def _accept(self, connection: Connection) -> None:
        number = self._last_number = (self._last_number + 1) % (1 << 32)
        channel = self._channels[number] = Channel(self._name, number, False, self._send)
        self._send(Opened(self._name, number, connection.key.local_port))
        join(connection, channel)

    def _send(self, message: RelayMessage) -> None:
        self._link.send(message)
        self._forget_if_over(message)

    def _on_message(self, message: RelayMessage) -> None:
        match message:
            case Offered():
                self._ports |= set(message.ports)
                self._listen()
            case Portion() | Consumed() | Ended() | Closed():
                channel = self._channels.get(message.number)
                if channel is not None:
                    channel.take(message)
                    self._forget_if_over(message)
                    self._on_change()

    def _forget_if_over(self, message: RelayMessage) -> None:
        if isinstance(message, Portion | Consumed | Ended | Closed):
            channel = self._channels.get(message.number)
            if channel is not None and channel.is_over:
                del self._channels[message.number]
