"""A CiA 402 drive alone on CAN: the profile engine of all axes, on a motor with its load.

Source: CiA 402-2 and CiA 301.  The drive has cycles of its own, as long as something moves or may move; without torque
and at rest it computes nothing.  A set value of a cycle is reached at its end.  Left out: the memory of an absolute
encoder, so a drive is not homed after power-on.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cached_property
from math import isfinite
from typing import Any, ClassVar, Final

from fieldrig.bus import Bus
from fieldrig.clock import Alarm, Clock
from fieldrig.device import Device, Point, Tool
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.storage.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal
from fieldrig_devices.canopen.node import CanopenNode
from fieldrig_devices.canopen.node_faults import MODELS as NODE_MODELS
from fieldrig_devices.canopen.node_tools import lines
from fieldrig_devices.canopen.service import Reset, Service
from fieldrig_devices.cia402.axis import COMMUNICATION_LOST, Cia402Axis
from fieldrig_devices.cia402.error_register import register_of
from fieldrig_devices.cia402.motor import Kind
from fieldrig_devices.cia402.objects import RATED_CURRENT, RATED_TORQUE
from fieldrig_devices.cia402.single import pdo_rules
from fieldrig_devices.cia402.single.faults import MODELS
from fieldrig_devices.cia402.single.front import front_of
from fieldrig_devices.cia402.single.manner_link import MannerLink
from fieldrig_devices.cia402.single.points import points_of
from fieldrig_devices.cia402.single.power_gate import PowerGate
from fieldrig_devices.cia402.single.servo import Servo
from fieldrig_devices.cia402.single.settings import Cia402DriveSettings
from fieldrig_devices.cia402.single.shared_wires import SharedWires
from fieldrig_devices.cia402.single.sync_watch import SYNC_LOST, SyncWatch
from fieldrig_devices.cia402.single.terminals import Inputs
from fieldrig_devices.cia402.single.unit_objects import UnitObjects
from fieldrig_devices.cia402.single.velocity_sensor import show_velocity
from fieldrig_devices.drives.position_wire import PositionWire

LARGEST_LOAD_NM: Final = 1e6
MOST_CYCLES: Final = 1_000
"""Most cycles to catch up with after a pause of the host; the rest is skipped."""
MOST_MADE_UP: Final = 500
"""Most cycles that are made up for, each with a set value of its own."""


class _Awake(Service):
    """Lets the drive look at its objects, and run a cycle, after a reset of its node."""

    def __init__(self, go_on: Callable[[], None]) -> None:
        self._go_on = go_on

    def reset(self, scope: Reset) -> None:
        self._go_on()


class Cia402Drive(Device):
    """A drive as a device of a rig."""

    about = "a servo drive on CAN (CiA 402), with motor and load, from its own EDS or any other one"
    has_cycle = True
    trouble_keys: ClassVar[Collection[str]] = ("error_code", "emcy.code")
    fault_models: ClassVar[Mapping[str, type[Any]]] = {**MODELS, **NODE_MODELS}

    def __init__(
        self,
        clock: Clock,
        name: str,
        settings: Cia402DriveSettings,
        can: Link[CanFrame],
        store: Store,
        wires: Link[Signal] | None = None,
    ) -> None:
        self._clock, self._settings = clock, settings
        self._cycle_ns = settings.cycle_us * 1_000
        manner = settings.manner
        end = MannerLink(clock, can, manner, settings.node_id or 0)
        shared = None if wires is None else SharedWires(wires)
        own = None if shared is None else shared.share()
        self.node = CanopenNode(
            clock,
            name,
            end if manner.concerns_frames else can,
            settings,
            store,
            None if shared is None else shared.share(),
        )
        self.node.read_when_sent()
        self._inputs = Inputs(settings, name, own)
        self.motor = Servo(clock, settings, self._inputs)
        self.injected = self.motor.faults
        self.node.take_faults(self.injected)
        self.axis = self._make_axis()
        self._gate = PowerGate(clock, self.motor, manner, self._on_gate)
        self.axis.machine.has_supply = self._gate.is_open
        pdo_rules.apply(manner.mapping, self.node)
        if manner.missed_syncs is not None:
            lost = self._on_sync_fault if manner.sync_loss == "fault" else self.axis.lose_connection
            end.sync_watch = SyncWatch(clock, self.node.dictionary, manner.missed_syncs, lost)
            self.node.attach(end.sync_watch)
        self._timer = Alarm(clock)
        self._begin_ns = self._due_ns = clock.now_ns()
        """The instants of the first cycle and of the next one."""
        self._spare = MOST_MADE_UP
        """Cycles that may still be made up for, so that a host that is always late does not fall behind permanently."""
        self._wires = own
        self._brake_wire, self._is_brake_shown = settings.wire_for(name, "brake"), False
        self._position: PositionWire | None = None
        if own is not None:
            self._position = PositionWire(settings.wire_for(name, "position"), settings.position_tolerance, own.send)
            self._connect(name, own)
        self.motor.on_change = self._go_on
        self.axis.pace.on_wake = self._go_on
        for fault in settings.faults:
            self.injected.add(fault)

    def _make_axis(self) -> Cia402Axis:
        settings, dictionary = self._settings, self.node.dictionary
        declared = settings.declared
        axis = Cia402Axis(
            self._clock, dictionary, 0, self.motor, self._cycle_ns, settings.chosen_behaviour(), declared.defaults
        )
        axis.on_errors = self._on_errors
        for index in declared.constants:
            dictionary.find(index, 0).reader = None
        for index in declared.constants & {RATED_TORQUE, RATED_CURRENT}:
            dictionary.find(index, 0).watchers.append(self._on_rated)
        self._rate()
        show_velocity(dictionary, self.motor)
        self.node.attach(_Awake(self._on_rated))
        units = UnitObjects(dictionary, lambda said: axis.use_units(said, declared.defaults_in(said)))
        self.node.attach(units)
        self.node.attach(axis)
        self.node.attach(_Awake(self._go_on))
        return axis

    def _on_rated(self) -> None:
        self._rate()
        self.axis.limit_torque()

    def _rate(self) -> None:
        """Take the rated torque and current that file or master give; 0 is none."""

        def given(index: int) -> float | None:
            is_given = index in self._settings.declared.constants
            return self.node.dictionary.number(index, 0) / 1_000 or None if is_given else None

        by_current = self._settings.manner.torque_base == "current"
        self.motor.rate(given(RATED_TORQUE), given(RATED_CURRENT), by_current)

    def _connect(self, name: str, wires: Link[Signal]) -> None:
        settings = self._settings
        handlers: dict[str, Callable[[float], None]] = {
            settings.wire_for(name, "sto"): self._on_sto,
            settings.wire_for(name, "load_torque"): self._on_load_torque,
            settings.wire_for(name, "blocked"): self._on_blocked,
        }

        def on_signal(signal: Signal) -> None:
            if not isfinite(signal.value):
                return
            if signal.name in handlers:
                handlers[signal.name](signal.value)
            else:
                self._inputs.take(signal, self.motor.capture)
                self.motor.on_input()

        wires.on_receive(on_signal, [*handlers, *self._inputs.bits])

    def start(self) -> None:
        self._begin_ns = self.motor.at_ns = self._clock.now_ns()
        self.node.start()
        self._publish()
        self._go_on()

    def front(self) -> Front:
        return front_of(self._settings)

    def points(self) -> Mapping[str, Point]:
        return self._points

    @cached_property
    def _points(self) -> Mapping[str, Point]:
        """They are the same as long as the drive has power, and a search reads them each millisecond."""
        return {**self.node.points(), **points_of(self.motor, self.axis, self._inputs)}

    def _on_sto(self, is_on: float) -> None:
        self.motor.switch_sto(bool(is_on))

    def _on_blocked(self, is_on: float) -> None:
        self.motor.block(bool(is_on))

    def _on_load_torque(self, torque_nm: float) -> None:
        self.motor.set_load(min(max(torque_nm, -LARGEST_LOAD_NM), LARGEST_LOAD_NM))

    def _on_gate(self) -> None:
        self.motor.is_changed = True
        self._go_on()

    def _on_sync_fault(self) -> None:
        if self.axis.machine.has_power:
            self.axis.fail(SYNC_LOST)

    def _on_errors(self, new: Sequence[int], gone: Collection[int]) -> None:
        """Signal each error event by an EMCY of its own, also those of one cycle."""
        emcy = self.node.emcy
        for code in new:
            # 8130h is the loss that the node has reported already, if it was one of the heartbeat or of the guarding.
            cause = self.motor.cause_of(code)
            register = register_of(code) if cause.error_register is None else cause.error_register
            emcy.raise_error(code, register, cause.info, source=1, is_shared=code == COMMUNICATION_LOST)
        for code in gone:
            emcy.clear_error(code, 1)

    # ---- cycles

    def _go_on(self) -> None:
        """Run the next cycle at its instant, unless that is planned already."""
        if not self._timer.is_set:
            passed = (self._clock.now_ns() - self._begin_ns) // self._cycle_ns
            self._due_ns = self._begin_ns + (passed + 1) * self._cycle_ns
            self._timer.at(self._due_ns, self._on_cycle)

    def _on_cycle(self) -> None:
        motor, axis = self.motor, self.axis
        now_ns = self._clock.now_ns()
        passed = 1 if motor.is_settled else min(max((now_ns - motor.at_ns) // self._cycle_ns, 1), MOST_CYCLES)
        missed = min(max(now_ns - self._due_ns, 0) // self._cycle_ns, passed - 1, self._spare)
        self._spare = min(self._spare - missed + 1, MOST_MADE_UP)
        self._cycle(passed - missed)
        for _ in range(missed):  # the host was late; without set values the motor would have stopped meanwhile
            self._cycle(1)
        for variable, read in self.node.watched:
            variable.set(read())
        self._publish()
        if not motor.is_settled or axis.pace.is_awake:
            self._go_on()
        if self.end_of_cycle is not None:
            self.end_of_cycle()

    def _cycle(self, passed: int) -> None:
        """Advance the motor by these cycles, at the end of which the axis gives it another set value."""
        motor, axis = self.motor, self.axis
        drive = axis.drive
        motor.advance(passed)
        if motor.is_changed or axis.pace.is_awake:
            motor.is_changed = False
            axis.step()
        elif drive.is_moving:
            drive.advance()
        if motor.is_following:
            motor.follow(drive.kind, drive.position_demand if drive.kind is Kind.POSITION else drive.set_value)

    def _publish(self) -> None:
        motor, wires = self.motor, self._wires
        if wires is None or self._position is None:
            return
        axis, gear = motor.axis, self._settings.load.gear_ratio
        speed = (axis.load_speed if axis.twist else axis.v) / gear
        self._position.publish(self._clock.now_ns(), motor.load_position, speed)
        if motor.is_brake_lifted is not self._is_brake_shown:
            self._is_brake_shown = motor.is_brake_lifted
            wires.send(Signal(self._brake_wire, motor.is_brake_lifted))

    @classmethod
    def tools(cls, name: str, settings: Cia402DriveSettings, links: Mapping[str, Bus[Any]]) -> list[Tool]:
        return lines(settings, links)
