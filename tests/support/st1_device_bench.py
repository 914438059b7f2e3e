"""A bench for the ST1 as a device: a PAM's end and one ST1 on a virtual ring and wires."""

from typing import Any

from pamring_bench import Pam
from st1_bench import AXIS

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.device import Value
from fieldrig.virtual.rig import Rig
from fieldrig_bus.wires import Signal
from fieldrig_devices.pamring.declared import DeclaredNode
from fieldrig_devices.pamring.frames import (
    Answer,
    AxisItem,
    Configuration,
    InputItem,
    NodeType,
    Order,
    OutputItem,
    Read,
)

ADDRESS = 17


class DeviceBench:
    """A PAM's end, and one ST1, `axis`, that is configured and runs; `more` are further devices of the rig."""

    def __init__(self, more: dict[str, Any] | None = None, **settings: Any) -> None:
        self.wires: list[tuple[int, Signal]] = []
        buses = {"ring0": {"kind": "pamring.virtual"}, "wires": {"kind": "wires.virtual"}}
        links = {"ring": "ring0", "wires": "wires"}
        device = {"kind": "st1", "ring_address": ADDRESS, "links": links, **settings}
        config = from_dict({"time": "virtual", "buses": buses, "devices": {"axis": device, **(more or {})}})
        self.rig = Rig(config, self._on_delivery)
        member = self.rig.attach("pam")
        self.pam = Pam(member.clock, member.link("ring0"), [DeclaredNode(1, NodeType.ST1, ADDRESS)])
        self.hand = self.rig.attach("hand").link("wires")
        items: list[Configuration] = [
            AxisItem(AXIS, 0, 0),
            InputItem(1, 101, 1, True, 1, 1),
            OutputItem(2, 201, 1, True),
        ]
        self.pam.ring.configure(ADDRESS, items)
        self.pam.start()
        self.run(200)
        assert not self.pam.errors

    def _on_delivery(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if bus.name == "wires" and delivery.sender == "axis" and isinstance(delivery.message, Signal):
            self.wires.append((delivery.time_ns, delivery.message))

    def run(self, ms: float) -> "DeviceBench":
        self.rig.run_until(self.rig.now_ns + round(ms * MS))
        return self

    def send(self, order: Order) -> "DeviceBench":
        self.pam.ring.send(ADDRESS, order)
        return self

    def drive(self, wire: str, value: float, unit: str = "") -> "DeviceBench":
        self.hand.send(Signal(f"axis.{wire}", value, unit))
        return self.run(0)

    def take(self, kind: type) -> list[Any]:
        found = [report for _, report in self.pam.reports if isinstance(report, kind)]
        self.pam.reports.clear()
        return found

    def get(self, point: str) -> Value:
        return self.rig.get("axis", point)

    def read(self, register: int) -> int | None:
        """Read a register over the ring."""
        self.pam.reports.clear()
        self.send(Read(99, register)).run(10)
        (answer,) = self.take(Answer)
        assert isinstance(answer, Answer)
        return answer.value
