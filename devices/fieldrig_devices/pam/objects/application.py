"""All objects of an application: built from its declarations, and worked in each basic cycle."""

import logging
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from fieldrig_devices.pam.language.check.symbols import ITEMS_FROM
from fieldrig_devices.pam.language.items import Declaration, Program
from fieldrig_devices.pam.objects.axes_set import AxesSet
from fieldrig_devices.pam.objects.axis import Axis
from fieldrig_devices.pam.objects.comparators import ComparatorItem, MultiComparatorItem
from fieldrig_devices.pam.objects.corrector_item import CorrectorItem
from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.encoder import Encoder
from fieldrig_devices.pam.objects.inputs import BinaryInput, CounterInput, DigitalInput, KeyInput
from fieldrig_devices.pam.objects.motor import DcMotor
from fieldrig_devices.pam.objects.nodes import declare_nodes, on_trouble
from fieldrig_devices.pam.objects.object_item import ObjectItem
from fieldrig_devices.pam.objects.outputs import (
    AnalogOutput,
    BinaryOutput,
    DigitalOutput,
    LedOutput,
    PamAnalogOutput,
    SevenSegmentOutput,
    Volts,
)
from fieldrig_devices.pam.objects.pipes import ConverterItem, Pipes
from fieldrig_devices.pam.objects.readings import ObjectReadings
from fieldrig_devices.pam.objects.site import ApplicationNode, Site
from fieldrig_devices.pam.objects.sources import PmpItem, SamplerItem, TmpItem
from fieldrig_devices.pam.objects.transformers import (
    AmplifierItem,
    CamItem,
    DerivatorItem,
    DistributorItem,
    PhaserItem,
    ProfileItem,
)
from fieldrig_devices.pam.objects.zero_positioner import FinePhases, ZeroPositioner
from fieldrig_devices.pam.pipes.cam import Shape
from fieldrig_devices.pam.pipes.converter import Sink
from fieldrig_devices.pam.runtime.item import Item, Kernel
from fieldrig_devices.pamring.ends import PamPort
from fieldrig_devices.pamring.frames import Answer, AxisReport, InputChanged, MotorReport, Report, Trouble

log = logging.getLogger(__name__)

ARITHMETIC_FAULT: Final = "02..FFF3"
"""Floating-point overflow, an invalid operation or a division by zero."""
ON_NODES: Final[Mapping[str, Callable[[Declared, Site, ApplicationNode], ObjectItem]]] = {
    "AXIS": Axis,
    "ENCODER": Encoder,
    "BINARY_INPUT": BinaryInput,
    "DIGITAL_INPUT": DigitalInput,
    "COUNTER_INPUT": CounterInput,
    "KEY_INPUT": KeyInput,
    "BINARY_OUTPUT": BinaryOutput,
    "DIGITAL_OUTPUT": DigitalOutput,
    "ANALOG_OUTPUT": AnalogOutput,
    "LED_OUTPUT": LedOutput,
    "D7SEG_OUTPUT": SevenSegmentOutput,
}
"""Kinds of objects with an item on each node of their declaration."""
BLOCKS: Final[Mapping[str, Callable[[Declared, Site], ObjectItem]]] = {
    "TMP_GENERATOR": TmpItem,
    "PMP_GENERATOR": PmpItem,
    "AMPLIFIER": AmplifierItem,
    "COMPARATOR": ComparatorItem,
    "DERIVATOR": DerivatorItem,
    "DISTRIBUTOR": DistributorItem,
    "PHASER": PhaserItem,
}
"""Blocks of pipes that need no other object."""

Shapes = Callable[[str], Shape]
"""Returns the curve of a cam file by its name.  ValueError if there is none, or if it cannot be read."""


def no_shapes(name: str) -> Shape:
    raise ValueError(f"there is no cam file {name}")


def no_volts(_address: int, _volts: float) -> None:
    pass


class SinkItem(ObjectItem, Sink):
    """A SINK, which has no functions (PAML-180)."""


class ApplicationObjects:
    """The `Objects` of the run time, and the receiver of the reports of all nodes."""

    def __init__(
        self,
        program: Program,
        kernel: Kernel,
        port: PamPort,
        *,
        readings: ObjectReadings | None = None,
        shapes: Shapes = no_shapes,
        volts: Volts = no_volts,
    ) -> None:
        """`volts` takes the voltages of the PAM's analog outputs."""
        self._site = Site(kernel, port, readings or ObjectReadings())
        self._pipes = Pipes(self._site)
        self._shapes, self._volts = shapes, volts
        self._followers: list[CamItem] = []
        """Cams that take a change of their profile over at once."""
        self._fine_phases = FinePhases()
        self._groups: dict[str, int] = {}
        self._items: dict[str, list[Any]] = {}
        self._group_of: dict[str, str] = {}
        """The NODES_GROUP that gives an object its items."""
        self._inactive: set[tuple[str, int]] = set()
        for item in program.items:
            if isinstance(item, Declaration):
                self._declare(Declared(item))
        self._addresses = {node.address: node for nodes in self._site.nodes.values() for node in nodes}

    # ---- declarations

    def _declare(self, declared: Declared) -> None:
        self._pipes.declare(declared)
        owners = filter(None, map(declared.reference, ITEMS_FROM))
        groups = (self._group_of.get(owner, "") for owner in owners)
        self._group_of[declared.name] = declared.reference("NODES_GROUP") or next(groups, "")
        if declared.kind == "NODES_GROUP":
            self._groups[declared.name] = declared.integer("NUMBER")
        elif declared.kind == "NODE":
            self._items[declared.name] = declare_nodes(declared, self._site, self._number(declared))
        elif declared.kind in ON_NODES:
            nodes = self._site.nodes[declared.reference("NODE")]
            self._items[declared.name] = [ON_NODES[declared.kind](declared, self._site, node) for node in nodes]
        elif declared.kind in BLOCKS:
            self._items[declared.name] = [BLOCKS[declared.kind](declared, self._site)]
        elif (build := getattr(self, f"_build_{declared.kind.lower()}", None)) is not None:
            self._items[declared.name] = build(declared)

    def _number(self, declared: Declared) -> int:
        """Return the number of items of a declaration by NUMBER or NODES_GROUP."""
        group = declared.reference("NODES_GROUP")
        return self._groups[group] if group else declared.integer("NUMBER", 1)

    def _build_pam_analog_output(self, declared: Declared) -> list[ObjectItem]:
        return [PamAnalogOutput(declared, self._site, self._volts)]

    def _build_dc_motor(self, declared: Declared) -> list[ObjectItem]:
        parts = [self._items[declared.reference(name)] for name in ("INC", "DEC", "ZERO", "ENCODER")]
        return [
            DcMotor(declared, self._site, zero.node, (increase, decrease), (zero, counter))
            for increase, decrease, zero, counter in zip(*parts, strict=False)
        ]

    def _build_axes_set(self, declared: Declared) -> list[ObjectItem]:
        members = [(axis, subset) for name, subset in declared.axes for axis in self._items[name]]
        return [AxesSet(declared.name, self._site, members, optimizes=declared.word("OPTIMIZE") == "YES")]

    def _build_sink(self, declared: Declared) -> list[ObjectItem]:
        return [SinkItem(declared.name)]

    def _build_zero_positioner(self, declared: Declared) -> list[ObjectItem]:
        axes = self._items[declared.reference("OBJECT")]
        sensors = self._items.get(declared.reference("SENSOR"), [])
        return [
            ZeroPositioner(
                declared,
                self._site,
                axis,
                sensors[min(index, len(sensors) - 1)] if sensors else None,
                self._fine_phases,
            )
            for index, axis in enumerate(axes)
        ]

    def _build_profile(self, declared: Declared) -> list[ObjectItem]:
        return [ProfileItem(declared, self._shapes(declared.reference("FILE")), self._followers)]

    def _build_cam(self, declared: Declared) -> list[ObjectItem]:
        def find(name: str) -> ProfileItem:
            profile: ProfileItem = self._items[name][0]
            return profile

        item = CamItem(declared, self._site, find(declared.reference("PROFILE")), find)
        if self._site.readings.profiles_act_at_once:
            self._followers.append(item)
        return [item]

    def _build_converter(self, declared: Declared) -> list[ObjectItem]:
        destination = self._items[declared.reference("DESTINATION")][0]
        return [ConverterItem(declared, self._site, destination, self._pipes)]

    def _build_corrector(self, declared: Declared) -> list[ObjectItem]:
        return [CorrectorItem(declared, self._site, self._items[declared.reference("TRIGGER_INPUT")][0])]

    def _build_multi_comparator(self, declared: Declared) -> list[ObjectItem]:
        item = MultiComparatorItem(declared, self._site)
        for trace in item.traces:
            self._items[trace.name] = [trace]
        return [item]

    def _build_sampler(self, declared: Declared) -> list[ObjectItem]:
        source = self._items[declared.reference("SOURCE")][0]
        if isinstance(source, Encoder):
            return [SamplerItem(declared, self._site, source.sample, source, source.position_period)]
        return [SamplerItem(declared, self._site, lambda: source.position, None, source.period)]

    # ---- the ring

    @property
    def nodes(self) -> Sequence[ApplicationNode]:
        """The declared nodes by their addresses, each with the items of its configuration."""
        return [self._addresses[address] for address in sorted(self._addresses)]

    def leave_out(self, addresses: Sequence[int]) -> None:
        """Ignore the components of nodes groups with a node that is missing on the ring, with all their nodes."""
        self._inactive |= {
            node.component for node in self.nodes if node.address in addresses and node.component is not None
        }
        for node in self.nodes:
            node.is_active = node.component not in self._inactive

    def on_report(self, address: int, report: Report) -> None:
        """Hand a report to the object that it is about; others are the ring's own."""
        node = self._addresses.get(address)
        if node is None:
            return
        match report:
            case InputChanged() | MotorReport():
                receiver = node.receivers.get((type(report), report.item))
                if receiver is not None:
                    receiver(report)
            case AxisReport() if node.axis_receiver is not None:
                node.axis_receiver(report)
            case Answer():
                self._site.on_answer(report)
            case Trouble():
                on_trouble(node, report, self._site)

    # ---- the run time

    @property
    def items(self) -> Mapping[str, Sequence[Item]]:
        return self._items

    def is_active(self, name: str, index: int) -> bool:
        return (self._group_of.get(name) or name, index) not in self._inactive

    def connect(self, blocks: Sequence[Item]) -> None:
        self._pipes.connect(blocks)  # type: ignore[arg-type]

    def take(self) -> None:
        self._site.take()

    def flow(self) -> None:
        """Let the pipes flow; numbers that get too large are a fault of the processor, which stops the programs."""
        try:
            self._pipes.flow()
        except (ArithmeticError, ValueError) as cause:  # ValueError: there is no remainder of an infinite number
            log.debug("a pipe: %s", cause)
            self._site.kernel.report(ARITHMETIC_FAULT)
        self._site.flowed()

    def give(self) -> None:
        """Do nothing: orders and set-points have been sent already, and leave with this basic cycle."""
