"""The way of messages between the ends of channels, which takes no time."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from fieldrig.bus import BusModel, Delivery
from fieldrig_bus.ip.message import (
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
)

RELAY: Final = "ip:relay"
"""The sender of refusals."""
REFUSED: Final = "no member offers this port"
UNKNOWN: Final = "there is no such channel"
LEFT: Final = "the other end has left"
NO_KERNEL: Final = "no member offers a kernel"
TAKEN: Final = "the kernel ends the link of another device"


@dataclass(slots=True)
class _Channel:
    opener: str
    service: str
    ended: set[str] = field(default_factory=set)

    def other(self, member: str) -> str:
        return self.service if member == self.opener else self.opener


class RelayModel(BusModel[OnRelay]):
    def __init__(self) -> None:
        self._members: list[str] = []
        self._due: list[Delivery[OnRelay]] = []
        self._latest_ns = 0
        self._offers: dict[str, Offered] = {}
        self._channels: dict[tuple[str, int], _Channel] = {}
        self._kernel: str | None = None
        self._link: LinkUp | None = None
        self._opened = self._refused = self._bytes = self._packets = 0

    def join(self, member: str) -> None:
        self._members.append(member)

    def leave(self, member: str) -> None:
        self._members.remove(member)
        self._offers.pop(member, None)
        self._due = [delivery for delivery in self._due if delivery.sender != member]
        self._leave_link(member)
        for (opener, number), channel in list(self._channels.items()):
            if member in (channel.opener, channel.service):
                del self._channels[opener, number]
                self._refuse(channel.other(member), opener, number, LEFT)

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        """Deliver the offers that were made before; all other messages name their channel."""
        self._latest_ns = max(self._latest_ns, now_ns)
        for sender, offer in self._offers.items():
            if sender != member:
                self._deliver(sender, offer, member)
        if self._kernel not in (None, member):
            self._deliver(str(self._kernel), KernelOffered(), member)

    def submit(self, now_ns: int, member: str, message: OnRelay) -> None:
        self._latest_ns = max(self._latest_ns, now_ns)
        match message:
            case Offered():
                self._offers[member] = message
                self._deliver(member, message, *(other for other in self._members if other != member))
            case Opened():
                self._open(member, message)
            case KernelOffered():
                self._kernel = member
                self._deliver(member, message, *(other for other in self._members if other != member))
            case LinkUp() | LinkDown() | IpPacket():
                self._pass_on_link(member, message)
            case Portion() | Consumed() | Ended() | Closed():
                self._pass_on(member, message)

    def cut(self, now_ns: int, opener: str, number: int, why: str, *, is_new: bool) -> None:
        """Lose a channel: its ends hear of it, of a new one only the opener."""
        self._latest_ns = max(self._latest_ns, now_ns)
        channel = self._channels.pop((opener, number), None)
        if channel is not None:
            self._refuse(channel.opener, opener, number, why)
            if not is_new:
                self._refuse(channel.service, opener, number, why)

    def next_ns(self) -> int | None:
        return self._due[0].time_ns if self._due else None

    def collect(self, now_ns: int) -> list[Delivery[OnRelay]]:
        deliveries = [delivery for delivery in self._due if delivery.time_ns <= now_ns]
        self._due = self._due[len(deliveries) :]
        return deliveries

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {
            "channels": float(len(self._channels)),
            "opened": float(self._opened),
            "refused": float(self._refused),
            "bytes": float(self._bytes),
            "packets": float(self._packets),
        }

    def _open(self, member: str, message: Opened) -> None:
        key = message.opener, message.number
        offering = (other for other in self._members if other in self._offers and other != member)
        service = next((other for other in offering if message.port in self._offers[other].ports), None)
        if member == self._kernel:
            service = self._link.device if self._link is not None and message.port in self._link.ports else None
        if message.opener != member:  # a channel in the name of another member
            self._deliver(member, message)
        elif service is None or key in self._channels:
            self._refused += 1
            self._deliver(member, message)
            self._refuse(member, *key, REFUSED)
        else:
            self._opened += 1
            self._channels[key] = _Channel(member, service)
            self._deliver(member, message, service)

    def _pass_on(self, member: str, message: Portion | Consumed | Ended | Closed) -> None:
        key = message.opener, message.number
        channel = self._channels.get(key)
        sender = None if channel is None else channel.service if message.is_answer else channel.opener
        if channel is None or sender != member:
            self._deliver(member, message)
            if isinstance(message, Portion):
                self._refuse(member, *key, UNKNOWN, not message.is_answer)
            return
        self._deliver(member, message, channel.other(member))
        if isinstance(message, Portion):
            self._bytes += len(message.data)
        if isinstance(message, Ended):
            channel.ended.add(member)
        if isinstance(message, Closed) or len(channel.ended) == 2:
            del self._channels[key]

    def _pass_on_link(self, member: str, message: LinkUp | LinkDown | IpPacket) -> None:
        """Carry messages between the kernel and the one device whose link it ends."""
        link, kernel = self._link, self._kernel
        is_linked = link is not None and message.device == link.device
        is_answer = not isinstance(message, LinkUp) and message.is_answer
        if member != (kernel if is_answer else message.device) or not (is_linked or isinstance(message, LinkUp)):
            self._deliver(member, message)
        elif isinstance(message, LinkUp) and (kernel is None or (link is not None and not is_linked)):
            self._deliver(member, message)
            self._deliver(RELAY, LinkDown(member, True, NO_KERNEL if kernel is None else TAKEN), member)
        else:
            self._deliver(member, message, message.device if is_answer else str(kernel))
            self._packets += isinstance(message, IpPacket)
            if not isinstance(message, IpPacket):
                self._link = message if isinstance(message, LinkUp) else None

    def _leave_link(self, member: str) -> None:
        link, kernel = self._link, self._kernel
        if link is not None and member in (link.device, kernel):
            self._link = None
            is_answer = member == kernel
            self._deliver(RELAY, LinkDown(link.device, is_answer, LEFT), link.device if is_answer else str(kernel))
        if member == kernel:
            self._kernel = None

    def _refuse(self, receiver: str, opener: str, number: int, why: str, is_answer: bool | None = None) -> None:
        direction = receiver == opener if is_answer is None else is_answer
        self._deliver(RELAY, Closed(opener, number, direction, why), receiver)

    def _deliver(self, sender: str, message: OnRelay, *receivers: str) -> None:
        self._due.append(Delivery(self._latest_ns, sender, message, receivers))
