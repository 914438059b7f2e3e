"""MC-4 MotorController: a servo drive on the fibre ring, with its motor and load.

Source: ELAU PacDrive system manual, article 17130061 (511-540, 4163-4196, chapter 10) and its digest; IEC 61491 for
what the manual doesn't say of the ring.  The drive has one axis, no user program, and talks to the controller over the
ring only; it configures itself from the name plate of the motor.  On wires it has the input Inverter Enable, the ready
contact and the brake relay as outputs, and beside them what the plant is made of: the load's torque, and its position.
Left out: probing (S-0-0169, S-0-0170), analog and logic encoder inputs, firmware download.
"""

from collections.abc import Mapping
from math import isfinite, tau
from typing import Any, Final

from fieldrig.clock import MS, Clock, Timer
from fieldrig.device import Device, Point, Value
from fieldrig.link import Link
from fieldrig_bus.ring.message import RingMessage
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.hiperface.drive_end import EncoderEnd, built_in, motor_data
from fieldrig_devices.hiperface.encoder import HiperfaceEncoder, eeprom_with
from fieldrig_devices.hiperface.line import InternalLine
from fieldrig_devices.hiperface.plate import NamePlate
from fieldrig_devices.hiperface.plate_file import load_plate
from fieldrig_devices.hiperface.shaft import TYPES, Turning
from fieldrig_devices.mc4.axis import RAD
from fieldrig_devices.mc4.idns import idn_table
from fieldrig_devices.mc4.machine import RPM, SLOW_NS, Machine
from fieldrig_devices.mc4.motor import INCREMENTS_PER_TURN
from fieldrig_devices.mc4.ring_side import RingSide
from fieldrig_devices.mc4.settings import Mc4Settings
from fieldrig_devices.sercos.idn import idn_of

TICK_NS: Final = 4 * MS
"""How often a drive that moves, or waits for a time, looks at itself while the ring doesn't lead it."""
LARGEST_LOAD_NM: Final = 1e6


class Mc4(Device):
    about = "ELAU MC-4: a servo drive with motor and load, on a fibre ring"

    def __init__(
        self,
        clock: Clock,
        name: str,
        settings: Mc4Settings,
        ring: Link[RingMessage],
        wires: Link[Signal] | None = None,
        encoder: Link[SerialMessage] | None = None,
    ) -> None:
        """Without the link `encoder` one is built in, with the plate of `motor` in its memory."""
        self._clock, self._settings, self._wires = clock, settings, wires
        table = idn_table()
        self._fill(table)
        plate = load_plate(settings.motor.name_plate) if settings.motor is not None else None
        self._timer: Timer | None = None
        self._side: RingSide | None = None
        self.machine = Machine(clock, settings, table, self._on_change, None if plate is None else motor_data(plate))
        self._encoder = self._encoder_at(encoder, plate)
        self.machine.encoder = self._encoder
        self._side = RingSide(clock, ring, settings.ring_address, table, self.machine)
        self._names = {
            what: settings.wire(name, what)
            for what in ("inverter_enable", "load_torque", "ready", "brake", "position", "shaft")
        }
        self._told: dict[str, bool] = {}
        self._courses: dict[str, Motion] = {}
        self._tells_shaft = encoder is not None or settings.shaft_wire is not None
        if wires is not None:
            self._side.on_moved = self._tell_positions
            inputs = {
                self._names["inverter_enable"]: self._on_inverter_enable,
                self._names["load_torque"]: self._on_load_torque,
            }
            wires.on_receive(lambda signal: inputs[signal.name](signal.value), tuple(inputs))

    def _encoder_at(self, link: Link[SerialMessage] | None, plate: NamePlate | None) -> EncoderEnd:
        settings, machine = self._settings, self.machine
        wanted = settings.motor.expected_type if settings.motor is not None else None
        if link is not None:
            return EncoderEnd(self._clock, link, motor_type=wanted)
        if plate is None:
            return EncoderEnd(self._clock, InternalLine(self._clock).ends[0])

        def shaft(_now_ns: int) -> Turning:
            return Turning(machine.shaft_increments / INCREMENTS_PER_TURN, machine.axis.v / tau)

        kind = TYPES["multi_turn" if plate.is_multi_turn else "single_turn"]
        return built_in(self._clock, HiperfaceEncoder(kind, eeprom_with(plate), shaft), wanted)

    def _fill(self, table: Any) -> None:
        settings = self._settings
        parameters, versions = settings.parameters, settings.versions
        table[30].set(f"{settings.amplifier.type} V{versions.firmware}")
        table[140].set(settings.amplifier.type)
        table[0x8000 | 30].set(f"V{versions.firmware}")
        table[0x8000 | 31].set(f"V{versions.hardware}")
        table[206].set(parameters.brake_disconnection_ms)
        table[207].set(parameters.brake_coupling_ms)
        table[0x8000 | 3].set(parameters.stop_time_limit_ms)
        option = parameters.enable_coast | parameters.error_coast << 1 | parameters.brake_coast << 2
        table[0x8000 | 4].set(option)
        table[0x8000 | 33].set(int(settings.language == "en"))
        for text, value in parameters.idns.items():
            table[idn_of(text)].set(value)

    def start(self) -> None:
        self._encoder.start()
        self.machine.start()
        self._on_tick()

    # ---- time without the ring

    def _on_tick(self) -> None:
        self._timer = None
        machine = self.machine
        if machine.is_cyclic:
            self._wake_at(self._clock.now_ns() + SLOW_NS)
            return
        machine.catch_up()
        machine.look()
        self._wake_at(self._clock.now_ns() + (TICK_NS if self._is_busy else SLOW_NS))

    @property
    def _is_busy(self) -> bool:
        return not (self.machine.is_settled and self.machine.axis.is_at_rest)

    def _wake_at(self, when_ns: int) -> None:
        if self._timer is not None:
            if self._timer.when_ns <= when_ns:
                return
            self._timer.cancel()
        self._timer = self._clock.call_at(when_ns, self._on_tick)

    def _on_change(self) -> None:
        side = self._side
        if side is None:
            return
        side.refresh()
        if not self.machine.is_cyclic and self._is_busy:
            self._wake_at(self._clock.now_ns() + TICK_NS)
        if self._wires is not None:
            self._tell("ready", self.machine.is_ready)
            self._tell("brake", self.machine.chain.is_brake_lifted)
            self._tell_positions()

    # ---- wires

    def _tell(self, what: str, value: bool) -> None:
        if self._wires is not None and self._told.get(what) is not value:
            self._told[what] = value
            self._wires.send(Signal(self._names[what], value))

    def _tell_positions(self) -> None:
        axis, gear = self.machine.axis, self._settings.load.gear_ratio
        shaft = self.machine.shaft_increments * RAD
        if self._tells_shaft:
            self._tell_course("shaft", shaft, axis.v)
        self._tell_course("position", (shaft - axis.twist) / gear, (axis.load_speed if axis.twist else axis.v) / gear)

    def _tell_course(self, what: str, position: float, speed: float) -> None:
        """When what was told has led astray."""
        now_ns, told = self._clock.now_ns(), self._courses.get(what)
        if told is not None:
            is_near = abs(told.at(now_ns) - position) <= self._settings.position_tolerance
            if is_near and (speed or not told.speed):
                return
        course = self._courses[what] = Motion(self._names[what], position, "rad", now_ns, speed)
        assert self._wires is not None
        self._wires.send(course)

    def _on_inverter_enable(self, is_on: float) -> None:
        self.machine.catch_up()
        self.machine.inverter_enable = bool(is_on)
        self.machine.look()

    def _on_load_torque(self, torque_nm: float) -> None:
        self.machine.set_load(min(max(torque_nm, -LARGEST_LOAD_NM), LARGEST_LOAD_NM))

    # ---- faults

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        return self.machine.faults.add_given(fault)

    def clear_fault(self, number: int) -> None:
        self.machine.faults.clear(number)

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        return self.machine.faults.about()

    # ---- points

    def points(self) -> Mapping[str, Point]:
        return {**self._state_points(), **self._motion_points(), **self._power_points()}

    def _state_points(self) -> dict[str, Point]:
        machine = self.machine
        chain = machine.chain
        side = self._side
        assert side is not None
        return {
            "axis_state": Point(lambda: chain.axis_state, None, "", "AxisState"),
            "mc4_state": Point(lambda: chain.mc4_state, None, "", "MC4State"),
            "stage": Point(lambda: chain.stage.name.lower(), None, "", "of the enable chain"),
            "diag_code": Point(lambda: int(machine.diagnosis.code), None, "", "DiagCode; 0: nothing is pending"),
            "diag_msg": Point(lambda: machine.diagnosis.text, None, "", "DiagMsg"),
            "quit": Point(lambda: not machine.diagnosis.code, self._write_quit, "", "write true to quit errors"),
            "inverter_enable": Point(
                lambda: machine.hardware_enable, self._write_inverter_enable, "", "the input of the safe stop"
            ),
            "controller_enable": Point(lambda: machine.controller, None, "", "ControllerEnable, by the ring"),
            "ready": Point(lambda: machine.is_ready, None, "", "the ready contact is closed"),
            "brake": Point(lambda: chain.is_brake_lifted, None, "", "the brake relay is closed: the brake lifts"),
            "torque_on": Point(lambda: chain.has_torque, None, "", "the motor is not free"),
            "phase": Point(lambda: side.slave.phase, None, "", "of the ring, CP0 to CP4"),
            "status": Point(side.status, None, "", "status word, S-0-0135, without the service channel"),
            "motor_type": Point(lambda: machine.motor.type if machine.motor else "", None, "", "by the name plate"),
            "plate": Point(self._plate_in_words, None, "", "that it was read, or why it could not be"),
            "motor_serial": Point(lambda: machine.motor.serial_number if machine.motor else ""),
        }

    def _motion_points(self) -> dict[str, Point]:
        machine = self.machine
        gear = self._settings.load.gear_ratio

        def current() -> float:
            return machine.axis.t / machine.true_motor.torque_constant_nm_per_a

        return {
            "position": Point(lambda: round(machine.axis.position), None, "incr", "1 000 000 a turn of the motor"),
            "speed": Point(lambda: machine.axis.v * RPM, None, "1/min", "of the motor"),
            "torque": Point(lambda: machine.axis.t, None, "N m", "of the motor"),
            "current": Point(current, None, "A"),
            "following_error": Point(lambda: round(machine.axis.e * 1e6 / tau), None, "incr"),
            "load_position": Point(lambda: (machine.shaft_increments * RAD - machine.axis.twist) / gear, None, "rad"),
            "load_torque": Point(
                lambda: machine.load_nm, self._write_load_torque, "N m", "at the load; positive pulls it back"
            ),
            "brake_on": Point(lambda: machine.axis.brake_is_on, None, "", "the holding brake holds"),
            "slow_cycles": Point(lambda: machine.axis.slow_cycles, None, "", "that were stepped, not folded"),
        }

    def _power_points(self) -> dict[str, Point]:
        machine = self.machine
        return {
            "mains": Point(lambda: machine.dc.is_mains_on, self._write_mains, "", "of this drive"),
            "dc_bus": Point(lambda: machine.dc.volt, None, "V", "DC circuit"),
            "motor_temperature": Point(lambda: machine.thermal.motor_c, None, "degC", "of the winding"),
            "casing_temperature": Point(lambda: machine.thermal.casing_c, None, "degC", "of the motor"),
            "amplifier_temperature": Point(lambda: machine.thermal.amplifier_c, None, "degC"),
            "ambient": Point(lambda: machine.thermal.ambient_c, self._write_ambient, "degC"),
            "overload": Point(lambda: machine.thermal.overload * 100, None, "%", "100 switches off"),
        }

    def _plate_in_words(self) -> str:
        return self._encoder.why or ("read" if self.machine.motor else "not read")

    def _write_quit(self, value: Value) -> None:
        if value is not True:
            raise ValueError("true")
        if not self.machine.quit():
            raise ValueError("not yet: the drive still stops, or what is wrong is still there")

    def _write_inverter_enable(self, value: Value) -> None:
        self._on_inverter_enable(_truth(value))

    def _write_load_torque(self, value: Value) -> None:
        self._on_load_torque(_number(value, "a torque in N m"))

    def _write_mains(self, value: Value) -> None:
        self.machine.dc.is_mains_on = _truth(value)

    def _write_ambient(self, value: Value) -> None:
        self.machine.thermal.ambient_c = _number(value, "a temperature in degC")


def _truth(value: Value) -> bool:
    if not isinstance(value, bool):
        raise ValueError("true or false")
    return value


def _number(value: Value, right: str) -> float:
    if isinstance(value, str | bool) or not isfinite(value):
        raise ValueError(right)
    return float(value)
