"""The MAx-4 as a CANopen device: one or more nodes with up to eight CiA 402 axes each.

Source: CiA 301, CiA 402-2 and 402-3; the manual names the library CANopen_S.lib without its objects (digest PD-302), so
the objects below 6000h are ours (docs/devices/pacdrive/cia402.md).  Nodes boot with the controller, and are silent
without power.  The face that enabled an axis last controls it until it disables the axis.
"""

import logging
import struct
from collections.abc import Collection, Sequence
from functools import partial
from typing import Final

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.shared import SharedLink
from fieldrig_devices.canopen.node import CanopenNode, CanopenSettings
from fieldrig_devices.cia402.axis import Cia402Axis
from fieldrig_devices.cia402.axis_drive import AxisDrive
from fieldrig_devices.cia402.error_register import register_of
from fieldrig_devices.cia402.pace import Pace
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.axis_inputs import check_terminals, terminals_in
from fieldrig_devices.max4.can import cells as can_face_cells
from fieldrig_devices.max4.can.errors import error_of
from fieldrig_devices.max4.can.motor import AxisMotor
from fieldrig_devices.max4.can.objects import EDS
from fieldrig_devices.max4.can.origins import Origins
from fieldrig_devices.max4.can.settings import AxisTerminals, CanFaceSettings
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.messages.diagnosis import ERROR_CLASSES

log = logging.getLogger(__name__)

CONTROLLER: Final = 0
"""Source number of errors that belong to no axis; axes count from 1."""
INFO: Final = struct.Struct("<HBBB")
"""Manufacturer-specific bytes of an EMCY: DiagCode, axis, AxisState, MC4State."""


class CanFace:
    """The nodes of one controller, which start with its first boot."""

    def __init__(self, clock: Clock, can: Link[CanFrame], controller: Controller, settings: CanFaceSettings) -> None:
        """ValueError if the settings do not fit the configuration of the controller."""
        self._controller, self._settings = controller, settings
        self._check()
        self._origins = Origins(controller.section("can_face"))
        shared = SharedLink(can)
        self.nodes = [
            FaceNode(clock, shared.share(), controller, settings, node_id, self._origins)
            for node_id in settings.node_ids
        ]
        self._is_running = False
        controller.on_boot(self._on_boot)
        controller.on_end(self._on_end)
        controller.each_cycle(self._on_cycle)

    def axis(self, name: str) -> Cia402Axis:
        """The axis with this symbolic name.  KeyError if there is none."""
        for node in self.nodes:
            for motor, axis in zip(node.motors, node.axes, strict=True):
                if motor.axis is not None and motor.axis.name == name:
                    return axis
        raise KeyError(name)

    def _check(self) -> None:
        controller, settings = self._controller, self._settings
        room = len(settings.node_ids) * settings.axes_per_node
        if len(controller.axes) > room:
            raise ValueError(
                f"node_ids: expected a node for each {settings.axes_per_node} axes, "
                f"got nodes for {room} axes and {len(controller.axes)} axes"
            )
        named = {
            name: (*terminals.all_inputs.values(), *terminals.all_outputs.values())
            for name, terminals in settings.terminals.items()
        }
        check_terminals(controller, "terminals", named)

    def _on_boot(self) -> None:
        axes = list(self._controller.axes.values())
        count = self._settings.axes_per_node
        for number, node in enumerate(self.nodes):
            node.boot(axes[number * count : (number + 1) * count])
        left = [axis.name for axis in axes[len(self.nodes) * count :]]
        if left:
            log.warning("no CANopen node is left for %s: add node-IDs to can_axes", ", ".join(left))
        self._is_running = True

    def _on_end(self) -> None:
        self._is_running = False
        for node in self.nodes:
            node.power_off()

    def _on_cycle(self) -> None:
        if not self._is_running:
            return
        for node in self.nodes:
            node.step()
        self.nodes[0].signal_controller_errors()


class FaceNode:
    """One node with its axes."""

    def __init__(
        self,
        clock: Clock,
        can: Link[CanFrame],
        controller: Controller,
        settings: CanFaceSettings,
        node_id: int,
        origins: Origins,
    ) -> None:
        self._clock, self._controller, self._settings, self._origins = clock, controller, settings, origins
        node_settings = CanopenSettings(node_id=node_id, eds=EDS, signals={}, objects=settings.objects)
        self.node = CanopenNode(clock, f"can{node_id}", can, node_settings, controller.section(f"can_face_{node_id}"))
        self.motors: list[AxisMotor] = []
        self.axes: list[Cia402Axis] = []
        self.node.read_when_sent()
        can_face_cells.connect(self.node.dictionary, controller)
        for number in range(settings.axes_per_node):
            self._add(number)
        self._stepped: list[tuple[AxisMotor, Cia402Axis, AxisDrive, Pace]] = []
        self._signalled: set[int] = set()
        """Error codes of the controller that are signalled."""
        self._places: tuple[str, ...] = ()
        """Beginnings of the DiagExtCode on the controller by which it refers to an axis."""

    def _add(self, number: int) -> None:
        motor = AxisMotor(self._controller.quit_all)
        axis = Cia402Axis(self._clock, self.node.dictionary, number, motor, self._controller.cycle_ns)
        motor.guide = axis.drive
        axis.on_errors = partial(self._on_errors, number + 1, motor)
        axis.on_home = partial(self._on_home, motor)
        can_face_cells.connect_axis(self.node.dictionary, number, motor)
        self.node.attach(axis)
        self.motors.append(motor)
        self.axes.append(axis)

    def boot(self, axes: list[Axis]) -> None:
        """Start the node with these axes of the controller."""
        tree = self._controller.tree
        for number, motor in enumerate(self.motors):
            axis = axes[number] if number < len(axes) else None
            name = axis.name if axis is not None else ""
            terminals = self._settings.terminals.get(name, AxisTerminals())
            motor.bind(axis, terminals_in(tree, terminals.all_inputs), terminals_in(tree, terminals.all_outputs))
            self.axes[number].use(self._controller.cycle_ns, self._origins.of(name))
        pairs = zip(self.motors, self.axes, strict=True)
        self._stepped = [(motor, axis, axis.drive, axis.pace) for motor, axis in pairs][: len(axes)]
        self._signalled.clear()
        self._places = tuple(f"{axis.ring_address}." for axis in self._controller.axes.values())
        self.node.start()

    def power_off(self) -> None:
        self.node.power_off()
        for motor in self.motors:
            motor.bind(None, {}, {})

    def step(self) -> None:
        for motor, axis, drive, pace in self._stepped:
            if motor.is_changed or pace.is_awake:
                motor.refresh()
                axis.step()
                motor.show_mode()
            elif drive.is_moving:
                drive.advance()
                if drive.kind is not motor.kind:
                    motor.show_mode()
        for variable, read in self.node.watched:
            variable.set(read())

    def _on_errors(self, source: int, motor: AxisMotor, new: Sequence[int], gone: Collection[int]) -> None:
        emcy, axis = self.node.emcy, motor.axis
        diag = axis.diag_code if axis is not None else 0
        states = (axis.axis_state.value, axis.mc4_state) if axis is not None else (0, 0)
        for code in new:
            emcy.raise_error(code, register_of(code), INFO.pack(diag, source, *states), source)
        for code in gone:
            emcy.clear_error(code, source)

    def _on_home(self, motor: AxisMotor, origin: float) -> None:
        if motor.axis is not None:
            self._origins.put(motor.axis.name, origin)

    def signal_controller_errors(self) -> None:
        """Signal errors of the controller that belong to no axis."""
        pending = self._controller.diagnosis.pending
        if not pending and not self._signalled:
            return
        present = {
            error_of(diagnosis.code): diagnosis
            for diagnosis in pending
            if diagnosis.diagnosis_class in ERROR_CLASSES and not diagnosis.ext.startswith(self._places)
        }
        for code in self._signalled - present.keys():
            self.node.emcy.clear_error(code, CONTROLLER)
        for code, diagnosis in present.items():
            info = INFO.pack(diagnosis.code, CONTROLLER, 0, 0)
            self.node.emcy.raise_error(code, register_of(code), info, CONTROLLER)
        self._signalled = set(present)
