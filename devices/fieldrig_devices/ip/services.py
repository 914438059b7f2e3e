"""The relay of a device with a link of its own.

The link's connections are carried over the relay to listeners outside, or to other devices.  If the relay offers a
kernel, IP ends there instead of in a stack.
"""

from collections.abc import Callable
from ipaddress import IPv4Address

from fieldrig.link import Link
from fieldrig_bus.ip.channel import Channel
from fieldrig_bus.ip.channels import Channels
from fieldrig_bus.ip.message import KernelOffered, Offered, Opened, RelayMessage
from fieldrig_bus.ip.stream import join
from fieldrig_devices.ip.kernel_end import Accepted, IpEnd, KernelEnd
from fieldrig_devices.ip.stack import Stack


class RelayedServices:
    """Listens at the end of IP at all ports that the relay offers, and opens a channel for each connection."""

    def __init__(self, name: str, link: Link[RelayMessage], on_change: Callable[[], None]) -> None:
        """`name` is the device's.  `on_change` is called after messages; the stack is then to be advanced."""
        self._name, self._link, self._on_change = name, link, on_change
        self._end: IpEnd | None = None
        self._kernel_end: KernelEnd | None = None
        self._has_kernel = False
        self._ports: set[int] = set()
        self._channels = Channels()
        self._last_number = 0
        link.on_receive(self._on_message)

    def end_of(
        self, stack: Stack, peer: IPv4Address, mtu: int, transmit: Callable[[bytes], None], waiting: Callable[[], int]
    ) -> IpEnd:
        """Return the end of IP for a link that is up: the kernel if the relay has one, or else `stack`.

        `attach` begins with it.  `transmit` sends a packet to the line, for which `waiting` bytes wait already.
        """
        self._kernel_end = None
        if not self._has_kernel:
            return stack
        self._kernel_end = KernelEnd(self._name, stack, peer, mtu, self._link.send, transmit, waiting)
        return self._kernel_end

    def attach(self, end: IpEnd | None) -> None:
        """Serve this end of IP from now on, instead of the one before; None without a link."""
        self._end = end
        self._listen()
        if end is not None and end is self._kernel_end:
            self._kernel_end.begin()

    def _listen(self) -> None:
        if self._end is not None:
            for port in self._ports:
                self._end.listen(port, self._accept)

    def _accept(self, connection: Accepted) -> None:
        number = self._last_number = (self._last_number + 1) % (1 << 32)
        channel = Channel(self._name, number, False, self._send)
        self._channels.add((self._name, number), channel)
        self._send(Opened(self._name, number, connection.key.local_port))
        join(connection, channel)

    def _send(self, message: RelayMessage) -> None:
        self._link.send(message)
        self._channels.sent(message)

    def _on_message(self, message: RelayMessage) -> None:
        if isinstance(message, Offered):
            self._ports |= set(message.ports)
            self._listen()
        elif isinstance(message, KernelOffered):
            self._has_kernel = True
        elif self._channels.take(message):
            self._on_change()
        elif self._kernel_end is not None:
            self._kernel_end.take(message)
            self._on_change()
