"""The way of messages between the server and devices, which takes no time."""

from collections.abc import Sequence
from typing import Any, Final

from fieldrig.bus import BusModel, Delivery
from fieldrig_bus.opcua.message import ANSWERS, Offer, OpcUaMessage

SERVER: Final = "opcua:server"
"""The member that is the server of the bus."""


class OpcUaModel(BusModel[OpcUaMessage]):
    """Requests go to the device that they name, everything else to the server."""

    def __init__(self) -> None:
        self._members: list[str] = []
        self._due: list[Delivery[OpcUaMessage]] = []
        self._latest_ns = 0
        self._requests = self._answers = 0
        self._offers: dict[str, tuple[str, Offer]] = {}

    def join(self, member: str) -> None:
        self._members.append(member)

    def leave(self, member: str) -> None:
        self._members.remove(member)
        self._offers = {device: offer for device, offer in self._offers.items() if offer[0] != member}
        self._due = [delivery for delivery in self._due if delivery.sender != member]

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        """Deliver the offers that were made before the server listened; messages themselves name their receiver."""
        if member == SERVER:
            for sender, offer in self._offers.values():
                self._due.append(Delivery(max(self._latest_ns, now_ns), sender, offer, (SERVER,)))

    def submit(self, now_ns: int, member: str, message: OpcUaMessage) -> None:
        self._latest_ns = max(self._latest_ns, now_ns)
        if isinstance(message, (Offer, *ANSWERS)):
            self._answers += isinstance(message, ANSWERS)
            receiver = SERVER
            if isinstance(message, Offer):
                self._offers[message.device] = member, message
        else:
            self._requests += 1
            receiver = message.device
        receivers = (receiver,) if receiver in self._members else ()
        self._due.append(Delivery(self._latest_ns, member, message, receivers))

    def next_ns(self) -> int | None:
        return self._due[0].time_ns if self._due else None

    def collect(self, now_ns: int) -> list[Delivery[OpcUaMessage]]:
        deliveries = [delivery for delivery in self._due if delivery.time_ns <= now_ns]
        self._due = self._due[len(deliveries) :]
        return deliveries

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {"requests": float(self._requests), "answers": float(self._answers)}
