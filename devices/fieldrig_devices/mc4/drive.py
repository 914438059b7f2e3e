"""MC-4 MotorController: a servo drive on the fibre ring, with its motor and load.

Source: ELAU PacDrive system manual, article 17130061 (511-540, 4163-4196, chapter 10) and its digest; IEC 61491 for
the ring, where the manual is silent.  The drive has one axis and no user program, and communicates with the controller
over the ring only; it configures itself from the name plate of the motor.  Its wires are the input Inverter Enable, the
outputs for ready contact and brake relay, and the torque and position of the load.
Left out: analog and logic encoder inputs, firmware download.
"""

from collections.abc import Callable, Collection, Mapping
from functools import cached_property, partial
from math import tau
from typing import Any, ClassVar, Final

from fieldrig.clock import MS, Alarm, Clock
from fieldrig.device import Device, Point
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig_bus.ring.sercos.message import RingMessage
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_bus.wires import Signal
from fieldrig_devices.drives.fold import PublishedMotion
from fieldrig_devices.drives.loops import RAD
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN
from fieldrig_devices.drives.position_wire import PositionWire
from fieldrig_devices.hiperface.drive_end import EncoderEnd, built_in, motor_data
from fieldrig_devices.hiperface.encoder import HiperfaceEncoder, eeprom_with
from fieldrig_devices.hiperface.line import InternalLine
from fieldrig_devices.hiperface.plate import NamePlate
from fieldrig_devices.hiperface.plate_file import load_plate
from fieldrig_devices.hiperface.shaft import TYPES, Turning
from fieldrig_devices.mc4 import idns
from fieldrig_devices.mc4.faults import MODELS
from fieldrig_devices.mc4.front import front_of
from fieldrig_devices.mc4.idn_points import idn_points
from fieldrig_devices.mc4.machine import Machine
from fieldrig_devices.mc4.points import limited_load, points_of
from fieldrig_devices.mc4.probes import PROBES
from fieldrig_devices.mc4.ring_side import RingSide
from fieldrig_devices.mc4.settings import Mc4Settings
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.datum import IdnTable
from fieldrig_devices.sercos.idn import idn_of

INPUTS: Final = ("inverter_enable", "load_torque", "probe_1", "probe_2")
SHAFTS: Final = ("position", "shaft")
TICK_NS: Final = 4 * MS
"""Interval at which a drive that moves or waits updates itself while the ring is not in operation."""


class Mc4(Device):
    """An MC-4 drive as a device of a rig."""

    about = "ELAU MC-4: a servo drive with motor and load, on a fibre ring"
    has_cycle = True
    trouble_keys: ClassVar[Collection[str]] = ("diag_code",)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(
        self,
        clock: Clock,
        name: str,
        settings: Mc4Settings,
        ring: Link[RingMessage],
        wires: Link[Signal] | None = None,
        encoder: Link[SerialMessage] | None = None,
    ) -> None:
        """If there is no link `encoder`, the encoder is built in and its memory contains the plate of `motor`."""
        self._clock, self._settings, self._wires = clock, settings, wires
        table = idns.idn_table()
        self._fill(table)
        plate = load_plate(settings.motor.name_plate) if settings.motor is not None else None
        self._timer = Alarm(self._clock)
        self._side: RingSide | None = None
        self.machine = Machine(clock, settings, table, self._on_change, None if plate is None else motor_data(plate))
        self.injected = self.machine.faults
        self._encoder = self._encoder_at(encoder, plate)
        self.machine.plate.encoder = self._encoder
        self._side = RingSide(clock, ring, settings.ring_address, table, self.machine)
        self._names = {what: settings.wire_for(name, what) for what in (*INPUTS, "ready", "brake", *SHAFTS)}
        self._sent: dict[str, bool] = {}
        self._positions: dict[str, PositionWire] = {}
        self._publishes_shaft = encoder is not None or settings.shaft_wire is not None
        if wires is not None:
            tolerance = settings.position_tolerance
            self._positions = {what: PositionWire(self._names[what], tolerance, wires.send) for what in SHAFTS}
            self._side.on_moved = self._publish_positions
            self._side.is_published = not self._publishes_shaft
            probes = self._side.probes
            handlers: list[Callable[[float], None]] = [self._on_inverter_enable, self._on_load_torque]
            handlers += [partial(probes.put, probe) for probe in PROBES]
            inputs = {self._names[what]: handler for what, handler in zip(INPUTS, handlers, strict=True)}
            wires.on_receive(lambda signal: inputs[signal.name](signal.value), tuple(inputs))

    @property
    def _ring_side(self) -> RingSide:
        assert self._side is not None, "only while the drive is built"
        return self._side

    def _encoder_at(self, link: Link[SerialMessage] | None, plate: NamePlate | None) -> EncoderEnd:
        settings, machine = self._settings, self.machine
        wanted = settings.motor.expected_type if settings.motor is not None else None
        if link is not None:
            return EncoderEnd(self._clock, link, motor_type=wanted)
        if plate is None:
            return EncoderEnd(self._clock, InternalLine(self._clock).ends[0])

        def shaft(now_ns: int) -> Turning:
            return Turning(machine.shaft_at(now_ns) / INCREMENTS_PER_TURN, machine.axis.v / tau)

        kind = TYPES["multi_turn" if plate.is_multi_turn else "single_turn"]
        return built_in(self._clock, HiperfaceEncoder(kind, eeprom_with(plate), shaft), wanted)

    def _fill(self, table: IdnTable) -> None:
        settings = self._settings
        parameters, versions = settings.parameters, settings.versions
        table[std.MANUFACTURER_VERSION].set(f"{settings.amplifier.type} V{versions.firmware}")
        table[std.CONTROLLER_TYPE].set(settings.amplifier.type)
        table[idns.FIRMWARE].set(f"V{versions.firmware}")
        table[idns.HARDWARE].set(f"V{versions.hardware}")
        table[idns.ARTICLE].set(versions.article_number)
        table[idns.OWN_SERIAL_NUMBER].set(versions.serial_number or f"{settings.ring_address:010}")
        table[std.DRIVE_ON_DELAY].set(parameters.brake_disconnection_ms)
        table[std.DRIVE_OFF_DELAY].set(parameters.brake_coupling_ms)
        table[idns.STOP_TIME_LIMIT].set(parameters.stop_time_limit_ms)
        option = parameters.enable_coast | parameters.error_coast << 1 | parameters.brake_coast << 2
        table[idns.COAST_OPTION].set(option)
        table[idns.LANGUAGE].set(int(settings.language == "en"))
        for text, value in parameters.idns.items():
            table[idn_of(text)].set(value)

    def start(self) -> None:
        self._encoder.start()
        self.machine.start()
        self._on_tick()

    # ---- time without the ring

    def _on_tick(self) -> None:
        machine = self.machine
        if not machine.is_cyclic:  # in operation the ring advances the drive; `_on_change` is called when that ends
            machine.catch_up()
            machine.look()

    @property
    def _is_busy(self) -> bool:
        return not (self.machine.is_settled and self.machine.axis.is_at_rest)

    def _wake_at(self, when_ns: int) -> None:
        if when_ns < self._timer.when_ns:
            self._timer.at(when_ns, self._on_tick)

    def _next_tick_ns(self) -> int:
        """Return when to look again.  All ticks are on one grid, so that those that a drive at rest leaves out change
        nothing about the instants of the others."""
        soon_ns = self._clock.now_ns() + 1
        due_ns = soon_ns if self._is_busy else max(soon_ns, self.machine.energy.due_ns)
        return -(-due_ns // TICK_NS) * TICK_NS

    def _on_change(self) -> None:
        side = self._side
        if side is None:
            return
        side.refresh()
        if not self.machine.is_cyclic:
            self._wake_at(self._next_tick_ns())
        if self._wires is not None:
            self._publish("ready", self.machine.is_ready)
            self._publish("brake", self.machine.chain.is_brake_lifted)
            self._publish_positions()

    # ---- wires

    def _publish(self, what: str, value: bool) -> None:
        if self._wires is not None and self._sent.get(what) is not value:
            self._sent[what] = value
            self._wires.send(Signal(self._names[what], value))

    def _publish_positions(self) -> None:
        axis, gear, now_ns = self.machine.axis, self._settings.load.gear_ratio, self._clock.now_ns()
        shaft = self.machine.shaft_increments * RAD
        if self._publishes_shaft:
            self._positions["shaft"].publish(now_ns, shaft, axis.v)
        load_speed = axis.load_speed if axis.twist else axis.v
        self._positions["position"].publish(now_ns, (shaft - axis.twist) / gear, load_speed / gear)
        motion = self._positions["position"].motion
        if self._side is not None and self._side.is_published and motion is not None:
            tolerance = self._settings.position_tolerance
            self._side.published = PublishedMotion(
                motion.value, motion.speed, motion.time_ns, tolerance, gear, self.machine.shaft_offset
            )

    def _on_inverter_enable(self, is_on: float) -> None:
        self.machine.catch_up()
        self.machine.inverter_enable = bool(is_on)
        self.machine.look()

    def _on_load_torque(self, torque_nm: float) -> None:
        self.machine.set_load(limited_load(torque_nm))

    # ---- points

    def front(self) -> Front:
        return front_of(self.machine)

    @property
    def end_of_cycle(self) -> Callable[[], None] | None:
        """The call at the end of each cycle of the ring (`Device.end_of_cycle`)."""
        return self._ring_side.slave.end_of_cycle

    @end_of_cycle.setter
    def end_of_cycle(self, action: Callable[[], None] | None) -> None:
        self._ring_side.slave.end_of_cycle = action

    def points(self) -> Mapping[str, Point]:
        return self._points

    @cached_property
    def _points(self) -> Mapping[str, Point]:
        side = self._ring_side
        own = points_of(self.machine, side, self._settings.load.gear_ratio, self._plate_text, self._on_inverter_enable)
        return {**own, **dict(idn_points(side.slave.table, lambda: side.slave.phase))}

    def _plate_text(self) -> str:
        return self._encoder.why or ("read" if self.machine.motor else "not read")
