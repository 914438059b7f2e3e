"""A PAM's end of a ring and nodes that do little, on a virtual ring."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Self

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, Clock
from fieldrig.config.rig_file import from_dict
from fieldrig.link import Link
from fieldrig.virtual.rig import Rig
from fieldrig_bus.ring.pam.message import RingMessage
from fieldrig_bus.ring.pam.virtual import PamRingSettings, PamRingVirtual
from fieldrig_devices.pamring.declared import DeclaredNode
from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.pamring.frames import (
    Answer,
    Configuration,
    InputChanged,
    InputItem,
    NodeType,
    Order,
    Read,
    Report,
)
from fieldrig_devices.pamring.master import RingMaster
from fieldrig_devices.pamring.node import RingNode
from fieldrig_devices.pamring.settings import RingLimits

ST1, SMART_IO = NodeType.ST1, NodeType.SMART_IO
SHORT = RingLimits(boot_ns=20 * MS, identify_ns=10 * MS, acknowledge_ns=10 * MS, first_value_ns=10 * MS)
"""Time-outs that a test can wait for."""


def third_of_ms(thirds: int) -> int:
    return thirds * MS // 3


class PlainNode:
    """A node whose inputs are 1 from the beginning, and that answers a `Read` with the number of the register."""

    def __init__(self, clock: Clock, link: Link[RingMessage], address: int, node_type: NodeType) -> None:
        self.end = RingNode(clock, link, address, node_type, 0x0590, self)
        self.items: list[Configuration] = []
        self.orders: list[Order] = []
        self.faults: list[RingFault] = []
        self.cycles = 0
        self.refused: frozenset[int] = frozenset()
        """The items that it cannot have."""
        self.silent: frozenset[int] = frozenset()
        """The inputs that don't report."""
        self.end.start()

    def forget(self) -> None:
        self.items.clear()

    def accept(self, item: Configuration) -> bool:
        if item.item in self.refused:
            return False
        self.items.append(item)
        return True

    def run(self) -> None:
        for item in self.items:
            if isinstance(item, InputItem) and item.item not in self.silent:
                self.end.send(InputChanged(item.item, 1))

    def order(self, order: Order) -> None:
        self.orders.append(order)
        if isinstance(order, Read):
            self.end.send(Answer(order.request, order.register))

    def cycle(self) -> None:
        self.cycles += 1

    def ring(self, fault: RingFault) -> None:
        self.faults.append(fault)


class Pam:
    """The rest of a PAM: its basic cycle, and what it shows."""

    def __init__(
        self, clock: Clock, link: Link[RingMessage], nodes: Sequence[DeclaredNode], settings: RingLimits = SHORT
    ) -> None:
        self._clock, self._cycle_ns = clock, third_of_ms(settings.thirds)
        self._link, self._settings = link, settings
        self.ring = RingMaster(clock, link, settings, nodes, self, self._say)
        self.said: list[tuple[str, tuple[int, ...]]] = []
        self.texts: list[str] = []
        self.reports: list[tuple[int, Report]] = []

    def start(self) -> None:
        self.ring.start()
        self._cycle()

    def reset(self, nodes: Sequence[DeclaredNode], items: Mapping[int, Sequence[Configuration]]) -> None:
        """The PAM forgets everything and begins again; its basic cycle goes on."""
        self.ring = RingMaster(self._clock, self._link, self._settings, nodes, self, self._say)
        for address, of_it in items.items():
            self.ring.configure(address, of_it)
        self.ring.start()

    def _cycle(self) -> None:
        self.ring.take()
        self.ring.give()
        self._clock.call_at(self._clock.now_ns() + self._cycle_ns, self._cycle)

    def on_report(self, address: int, report: Report) -> None:
        self.reports.append((address, report))

    def _say(self, code: str, details: Sequence[int], text: str) -> None:
        self.said.append((code, tuple(details)))
        if text:
            self.texts.append(text)

    @property
    def errors(self) -> list[tuple[str, tuple[int, ...]]]:
        return [(code, details) for code, details in self.said if "..M" not in code]

    @property
    def codes(self) -> list[str]:
        return [code for code, _ in self.said]


class Bench:
    """A virtual ring with nodes at these addresses, in this order."""

    def __init__(
        self,
        declared: Sequence[DeclaredNode],
        there: Iterable[tuple[int, NodeType]],
        settings: RingLimits = SHORT,
        **bus: Any,
    ) -> None:
        self.trace: list[tuple[int, str, RingMessage]] = []
        config = from_dict({"time": "virtual", "buses": {"ring0": {"kind": "pamring.virtual"}}})
        ring = PamRingVirtual("ring0", PamRingSettings(**bus))  # stations that it names are in no rig file
        entry = replace(config.buses["ring0"], bus=ring)
        self.rig = Rig(replace(config, buses={"ring0": entry}), self._on_delivery)
        member = self.rig.attach("pam")
        self.pam = Pam(member.clock, member.link("ring0"), declared, settings)
        self.nodes: list[PlainNode] = []
        for place, (address, node_type) in enumerate(there):
            member = self.rig.attach(f"n{place}")
            self.nodes.append(PlainNode(member.clock, member.link("ring0"), address, node_type))
        self.run(0)

    def _on_delivery(self, _bus: Bus[Any], delivery: Delivery[Any]) -> None:
        self.trace.append((delivery.time_ns, delivery.sender, delivery.message))

    def configure(self, items: Mapping[int, Sequence[Configuration]]) -> Self:
        for address, of_it in items.items():
            self.pam.ring.configure(address, of_it)
        return self

    def start(self) -> Self:
        """Power everything on, and wait as long as any start takes."""
        self.pam.start()
        return self.run(200)

    def run(self, ms: float) -> Self:
        self.rig.run_until(self.rig.now_ns + round(ms * MS))
        return self

    def node(self, address: int) -> PlainNode:
        return next(node for node in self.nodes if node.end.address == address)

    def fault(self, **fault: Any) -> int:
        return self.rig.add_fault("ring0", fault)
