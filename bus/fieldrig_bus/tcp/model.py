"""The way of messages between the port and the devices, which takes no time."""

from collections.abc import Sequence
from typing import Any, Final

from fieldrig.bus import BusModel, Delivery, words_of
from fieldrig_bus.tcp.message import Close, Connect, Connected, Data, Listen, Taken, TcpMessage, Unlisten

PORT: Final = "tcp:port"
"""The member that accepts the connections."""


class TcpModel(BusModel[TcpMessage]):
    """A new connection goes to the first member that listens to its service, which then owns it.

    A connection to a service that no member has is closed, and so are those of a member that leaves.
    """

    def __init__(self) -> None:
        self._services: dict[str, frozenset[Any] | None] = {}
        self._owners: dict[int, str] = {}
        self._due: list[Delivery[TcpMessage]] = []
        self._latest_ns = 0
        self._connections = self._bytes_in = self._bytes_out = 0

    def join(self, member: str) -> None:
        self._services[member] = frozenset()

    def leave(self, member: str) -> None:
        del self._services[member]
        self._due = [delivery for delivery in self._due if delivery.sender != member]
        for connection in [number for number, owner in self._owners.items() if owner == member]:
            self._close(connection)

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        self._services[member] = None if interest is None else frozenset(words_of(interest))

    def submit(self, now_ns: int, member: str, message: TcpMessage) -> None:
        self._latest_ns = max(self._latest_ns, now_ns)
        if isinstance(message, Data):
            if member == PORT:
                self._bytes_in += len(message.data)
            else:
                self._bytes_out += len(message.data)
        if isinstance(message, Data | Taken | Close | Listen | Unlisten | Connect) and member != PORT:
            is_own = self._owners.get(message.connection) == member
            self._add(member, message, PORT if is_own else "")
        elif member == PORT:
            self._from_port(message)

    def _from_port(self, message: TcpMessage) -> None:
        if isinstance(message, Connected):
            self._connections += 1
            owner = self._owners.get(message.origin) if message.origin else self._server_of(message.service)
            if owner is None:
                self._close(message.connection)
                return
            self._owners[message.connection] = owner
        self._add(PORT, message, self._owners.get(message.connection, ""))

    def _server_of(self, service: str) -> str | None:
        for member, services in self._services.items():
            if member != PORT and (services is None or service in services):
                return member
        return None

    def _close(self, connection: int) -> None:
        """Close a connection because its device is not there."""
        self._owners.pop(connection, None)
        self._add(PORT, Close(connection), PORT)

    def _add(self, sender: str, message: TcpMessage, receiver: str) -> None:
        receivers = (receiver,) if receiver in self._services else ()
        self._due.append(Delivery(self._latest_ns, sender, message, receivers))
        if isinstance(message, Close):
            self._owners.pop(message.connection, None)

    def owner_of(self, connection: int) -> str | None:
        """Return the member that owns a connection; None if it has ended."""
        return self._owners.get(connection)

    def next_ns(self) -> int | None:
        return self._due[0].time_ns if self._due else None

    def collect(self, now_ns: int) -> list[Delivery[TcpMessage]]:
        deliveries = [delivery for delivery in self._due if delivery.time_ns <= now_ns]
        self._due = self._due[len(deliveries) :]
        return deliveries

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {
            "connections": float(self._connections),
            "bytes_in": float(self._bytes_in),
            "bytes_out": float(self._bytes_out),
        }
