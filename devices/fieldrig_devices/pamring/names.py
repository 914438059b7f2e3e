"""Messages of a PAM's ring by name: orders and reports by the nodes of the rig and the objects of the application.

One message has the frames of a whole cycle, so it has several kinds and nodes.  Which nodes are in a group of axes is
learnt from the orders of the PAM (PAML-162).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from typing import Any, Final

from fieldrig.bus import Bus
from fieldrig.points.values import counted
from fieldrig.traces.names import Member, Named, Namer, of_several
from fieldrig.traces.parts import Part, Parts
from fieldrig_bus.ring.pam.message import BROADCAST, GROUP, Cycle, Frame, Frames, Reception, Reports, show
from fieldrig_devices.pamring.codec import decode_order, decode_report, split
from fieldrig_devices.pamring.described import DescribedNode, HasRingObjects
from fieldrig_devices.pamring.frame_parts import frame_parts
from fieldrig_devices.pamring.frame_words import KINDS, UNKNOWN, words
from fieldrig_devices.pamring.frames import Group

RECEPTIONS: Final = {Reception.NO_CARRIER: "no carrier", Reception.CRC_ERROR: "wrong CRC"}
Told = tuple[str, str, str]
"""Kind, node and text of one frame."""


class PamRingNames:
    """Names the messages of one ring."""

    def __init__(self, names: Mapping[int, str], nodes: Mapping[int, DescribedNode]) -> None:
        """`names` are those of the rig and `nodes` those of the application, by address."""
        self._names, self._nodes = dict(names), dict(nodes)
        self._addresses = {name: address for address, name in self._names.items()}
        self._groups: dict[int, int] = {}
        """The group of each node that has one."""

    def __call__(self, message: Any, sender: str = "") -> Named:
        match message:
            case Cycle() if message.reception is not Reception.GOOD:
                return Named(RECEPTIONS[message.reception], "", "")
            case Frames() | Cycle():
                return of_several("cycle", self._orders(message.frames))
            case Reports():
                trouble = self._trouble(message)
                return of_several("cycle", self._reports(message.reports), trouble)._replace(
                    aside=f"{message.late} late" if message.late else ""
                )
            case bytes():
                return of_several("reports", self._buffer(self._addresses.get(sender, 0), message))
        return Named("fault", sender, show(message))

    def parts(self, message: Any, request: bytes = b"") -> Parts | None:
        """Return the fields of all orders or reports of one cycle, by their nodes, kinds and objects."""
        match message:
            case Frames():
                return Parts("", "orders", self._order_parts(message.frames))
            case Cycle():
                state = Part("reception", "", int(message.reception), RECEPTIONS.get(message.reception, "good"))
                return Parts("", "orders", (state, *self._order_parts(message.frames)))
            case Reports():
                late = Part("late", "", message.late, f"{counted(message.late, 'node')}")
                trouble = Part("trouble", "", self._trouble(message), self._trouble(message) or "none")
                found = (self._report_parts(address, buffer) for address, buffer in message.reports)
                return Parts("", "reports", (late, trouble, *chain.from_iterable(found)))
        return None

    def _order_parts(self, sent: Iterable[Frame]) -> list[Part]:
        """Return the fields of all orders; the group of a target is its number, which needs nothing that was learnt."""
        told: list[tuple[str, DescribedNode, Any]] = []
        for target, contents in sent:
            name = f"group {target - GROUP}" if target > GROUP else self._target(target)
            try:
                told.append((name, self._nodes.get(target, UNKNOWN), decode_order(contents)))
            except ValueError:
                told.append((name, UNKNOWN, contents))
        return frame_parts(told)

    def _report_parts(self, address: int, buffer: bytes) -> list[Part]:
        name, node = self._name(address), self._nodes.get(address, UNKNOWN)
        try:
            return frame_parts([(name, node, report) for report in map(decode_report, split(buffer))])
        except ValueError:
            return frame_parts([(name, node, buffer)])

    def _name(self, address: int) -> str:
        return self._names.get(address) or self._nodes.get(address, UNKNOWN).name or f"node {address}"

    def _orders(self, sent: Iterable[Frame]) -> Iterator[Told]:
        for target, contents in sent:
            try:
                order = decode_order(contents)
            except ValueError:
                yield "no order", self._target(target), contents.hex(" ").upper()
                continue
            if isinstance(order, Group) and target <= 0xFF:
                self._groups[target] = order.number
            yield KINDS[type(order)], self._target(target), words(order, self._nodes.get(target, UNKNOWN))

    def _target(self, target: int) -> str:
        """Return the node or the nodes of a target."""
        if target == BROADCAST:
            return "all"
        if target <= GROUP:
            return self._name(target)
        members = [self._name(node) for node, group in sorted(self._groups.items()) if group == target - GROUP]
        return " ".join([f"group {target - GROUP}", *members])

    def _reports(self, buffers: Iterable[Frame]) -> Iterator[Told]:
        for address, buffer in buffers:
            yield from self._buffer(address, buffer)

    def _buffer(self, address: int, buffer: bytes) -> Iterator[Told]:
        name, node = self._name(address), self._nodes.get(address, UNKNOWN)
        try:
            for report in map(decode_report, split(buffer)):
                yield KINDS[type(report)], name, words(report, node)
        except ValueError:
            yield "no report", name, buffer.hex(" ").upper()

    def _trouble(self, message: Reports) -> str:
        parts = []
        if message.reception is not Reception.GOOD:
            parts.append(f"{RECEPTIONS[message.reception]} at {self._name(message.place) if message.place else 'PAM'}")
        if message.late:
            parts.append(f"{message.late} late")
        return ", ".join(parts)


def namer(bus: Bus[Any], members: Sequence[Member]) -> Namer:
    """Return the namer of a PAM's ring with these devices."""
    names: dict[int, str] = {}
    nodes: dict[int, DescribedNode] = {}
    for member in members:
        settings = member.entry.settings
        if isinstance(settings, HasRingObjects):
            nodes.update(settings.ring_objects())
        for claim in member.claims("ring address"):
            if isinstance(claim.value, int):
                names[claim.value] = member.entry.name
    return PamRingNames(names, nodes)
