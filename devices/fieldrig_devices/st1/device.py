"""ST1: a servo node on the ring of a PAM, with one axis, its motor, and I/O boards.

Source: Socapel PAM reference manual V2.5, chapters 2.3, 2.4, 2.7, 7, 9, 12, appendix D (rows PAML-040 to PAML-065,
PAMS-049, PAMS-055, PAMS-110 of the digests).  The manuals of the ST1 itself are lost, so its loops are ours: `shaft.py`
follows exactly within the torque, and `outer_shaft.py` closes a loop over wires.  The wires carry the terminals of the
boards, the position of the load, and what loads, heats and supplies the motor.
Left out: local actions, the keyboard of the ST1 and its serial line, elasticity between motor and load.
"""

from collections.abc import Callable, Collection, Mapping
from functools import cached_property, partial
from math import tau
from typing import Any, ClassVar

from fieldrig.clock import MS, Clock, S
from fieldrig.device import Device, Point, Value
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig_bus.ring.pam.message import RingMessage
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.pamring.axis_words import Error
from fieldrig_devices.pamring.frames import NodeType, Report
from fieldrig_devices.pamring.node import RingNode
from fieldrig_devices.pamring.points import ring_troubles
from fieldrig_devices.st1.faults import MODELS
from fieldrig_devices.st1.front import front_of
from fieldrig_devices.st1.points import points_of
from fieldrig_devices.st1.program import Program
from fieldrig_devices.st1.sensors import Sensors, limited
from fieldrig_devices.st1.settings import INPUTS, WIRES_IN, St1Settings
from fieldrig_devices.st1.shaft import TURN
from fieldrig_devices.st1.sources import initial_values, registers_of


class St1(Device):
    """An ST1 as a device of a rig."""

    about = "Socapel ST1: a servo node with motor and I/O boards, on the ring of a PAM"
    has_cycle = True
    trouble_keys: ClassVar[Collection[str]] = ("error",)
    diagnosis_keys: ClassVar[Collection[str]] = ("errors",)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        name: str,
        settings: St1Settings,
        ring: Link[RingMessage],
        wires: Link[Signal] | None = None,
    ) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self._name = name
        self.program = Program(clock, settings, self, self._drive)
        self._end = RingNode(
            clock,
            ring,
            settings.ring_address,
            NodeType.ST1,
            int(str(settings.firmware), 16),
            self.program,
            settings.ring_inactive_ms * MS,
        )
        servo = self.program.servo
        self.injected = servo.causes.faults
        self.sensors = Sensors(clock)
        self.further = {
            "variables": initial_values(settings.variables),
            "parameters": initial_values(settings.further_parameters),
        }
        self.program.registers = registers_of(servo, self.program.boards, self.sensors, clock.now_ns, self.further)
        self._rad = tau / TURN / settings.motor.gear_ratio
        self._set, self._tolerance = servo.set, settings.position_tolerance
        self._position_wire = settings.wire_for(name, "position")
        self._published: Motion | None = None
        if wires is not None:
            self._inputs = self._handlers()
            wires.on_receive(self._on_signal, tuple(self._inputs))
            if settings.plant is None:
                servo.on_change, servo.on_steady = self._publish, self._publish_steady
            servo.refer = self._refer

    def start(self) -> None:
        self.program.boards.start()
        self.program.servo.start()
        self._end.start()

    def send(self, report: Report) -> None:
        """Lay a report of the program into the buffer of the ring."""
        self._end.send(report)

    def front(self) -> Front:
        return front_of(self._settings)

    @property
    def end_of_cycle(self) -> Callable[[], None] | None:
        """The call at the end of each cycle of the ring (`Device.end_of_cycle`)."""
        return self._end.end_of_cycle

    @end_of_cycle.setter
    def end_of_cycle(self, action: Callable[[], None] | None) -> None:
        self._end.end_of_cycle = action

    def points(self) -> Mapping[str, Point]:
        return self._points

    @cached_property
    def _points(self) -> Mapping[str, Point]:
        return points_of(self, self._end)

    def troubles(self) -> Mapping[str, Value]:
        return {**super().troubles(), **ring_troubles(self._end)}

    # ---- wires

    def _handlers(self) -> dict[str, Callable[[Signal], None]]:
        """Return what takes each input, by its wire."""
        settings, name, boards = self._settings, self._name, self.program.boards

        def level(number: int, signal: Signal) -> None:
            boards.put(number, bool(signal.value))

        def register(kind: str, code: int, scale: float, signal: Signal) -> None:
            self.further[kind][code] = round(limited(signal.value * scale))

        handlers: dict[str, Callable[[Signal], None]] = {
            settings.terminal(name, f"IN{number}"): partial(level, number) for number in INPUTS
        }
        for what in WIRES_IN:
            handlers[settings.wire_for(name, what)] = getattr(self, f"_on_{what}")
        for kind, registers in (("variables", settings.variables), ("parameters", settings.further_parameters)):
            for code, of_it in registers.items():
                if of_it.wire is not None:
                    handlers[of_it.wire] = partial(register, kind, code, of_it.scale)
        if settings.plant is not None:
            handlers[settings.plant.encoder_wire] = self.program.servo.measure
        return handlers

    def _on_signal(self, signal: Signal) -> None:
        self._inputs[signal.name](signal)

    def _on_enable(self, signal: Signal) -> None:
        self.program.servo.switch(bool(signal.value))

    def _on_load_torque(self, signal: Signal) -> None:
        self.put_load(float(signal.value))

    def _on_motor_temperature(self, signal: Signal) -> None:
        self.put_temperature(float(signal.value))

    def _on_supply(self, signal: Signal) -> None:
        self.put_supply(float(signal.value))

    def _on_auxiliary(self, signal: Signal) -> None:
        self.put_auxiliary(bool(signal.value))

    def _on_analog(self, signal: Signal) -> None:
        self.sensors.analog_v = limited(float(signal.value))

    def _on_second(self, signal: Signal) -> None:
        self.sensors.second = signal

    def _on_incremental(self, signal: Signal) -> None:
        self.sensors.incremental = signal

    def _drive(self, number: int, level: bool) -> None:
        if self._wires is not None:
            self._wires.send(Signal(self._settings.terminal(self._name, f"OUT{number}"), level))

    def _refer(self, volts: float) -> None:
        assert self._wires is not None
        self._wires.send(Signal(self._settings.reference_wire(self._name), volts, "V"))

    def _publish(self) -> None:
        """Publish the position of the load again once the extrapolated one is off by more than the tolerance."""
        now_ns, shaft, rad, last = self._clock.now_ns(), self.program.servo.shaft, self._rad, self._published
        position, speed = shaft.position_at(now_ns) * rad, shaft.speed_at(now_ns) * rad
        acceleration = shaft.acceleration_at(now_ns) * rad
        if last is not None and acceleration == last.acceleration and (speed or not last.speed):
            is_near = abs(last.at(now_ns) - position) <= self._tolerance
            if is_near:
                return
        self._published = Motion(self._position_wire, position, "rad", now_ns, speed, acceleration)
        assert self._wires is not None
        self._wires.send(self._published)

    def _publish_steady(self, now_ns: int) -> None:
        """Do the same where the speed is not 0, and the acceleration is."""
        last = self._published
        if last is None or last.acceleration:
            self._publish()
            return
        expected = last.value + last.speed * (now_ns - last.time_ns) / S
        if abs(self._set.motor_at(now_ns) * self._rad - expected) > self._tolerance:
            self._publish()

    # ---- inputs, from wires and points

    def put_load(self, load_nm: float) -> None:
        """Take the torque at the load, which acts like friction."""
        self.program.servo.load(limited(load_nm) / self._settings.motor.gear_ratio)

    def put_temperature(self, degc: float) -> None:
        self.sensors.temperature_degc = limited(degc)
        self.program.servo.put(Error.MOTOR_TEMPERATURE, degc > self._settings.motor.temperature_limit_degc)

    def put_supply(self, volts: float) -> None:
        self.sensors.supply_v = limited(volts)
        limits, servo = self._settings.supply, self.program.servo
        servo.put(Error.OVER_VOLTAGE, volts > limits.highest_v)
        servo.put(Error.INT_SUPPLY_FAILURE, volts < limits.lowest_v)

    def put_auxiliary(self, is_there: bool) -> None:
        self.program.servo.put(Error.AUX_SUPPLY_FAILURE, not is_there)
