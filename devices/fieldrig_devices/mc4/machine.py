"""The drive behind its ring interface: enable chain, diagnosis, axis, DC circuit and temperatures together.

Source: manual chapter 10 and 513-540; digest 1.5, 1.8, 1.9.  This module does not know
the ring: the ring side sets `controller` and so on, advances the axis, and calls `look` when something may have
changed.  Temperatures, DC circuit and overload are evaluated every 64 ms.
"""

from collections.abc import Callable
from typing import Final, NamedTuple

from fieldrig.clock import MS, Clock
from fieldrig.faults.faults import Fault, Faults
from fieldrig_devices.drives.axis import Axis, IdealAxis, Moment
from fieldrig_devices.drives.load import plant_of
from fieldrig_devices.drives.loops import INCREMENTS, INNER_NS, Gains, Limits, Plant
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN, MotorData
from fieldrig_devices.mc4 import idns, tuning
from fieldrig_devices.mc4.actuators import AxisTask, Brake
from fieldrig_devices.mc4.causes import Causes, given, measured
from fieldrig_devices.mc4.diagnosis import LIMITS, Code, Diagnosis
from fieldrig_devices.mc4.enable import EnableChain, Limit, Reaction, Seen, Stage, Times
from fieldrig_devices.mc4.energy import Energy
from fieldrig_devices.mc4.faults import (
    MODELS,
    DcBus,
    DriveFaults,
    EnableLost,
    EncoderMemory,
    EncoderSignal,
    StuckBrake,
    WrongMotor,
)
from fieldrig_devices.mc4.plate import Plate, PlateReader
from fieldrig_devices.mc4.power import DcCircuit
from fieldrig_devices.mc4.settings import Mc4Settings
from fieldrig_devices.mc4.thermal import Thermal
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.datum import IdnTable

MOST_STEPS: Final = 4_000
"""Largest number of inner steps to catch up with; after a pause of more than a second, the rest is skipped."""
STEP: Final = 31
"""Resolution of the encoder's serial position, in increments."""


class Windows(NamedTuple):
    """Parameters that `look` compares with, in the units of the axis."""

    standstill: float
    position: int
    load: float
    """S-0-0114, as a fraction."""


class Machine:
    """A drive with its motor, without its ring interface."""

    __slots__ = (
        "_causes", "_clock", "_is_motor_given", "_on_change", "_table", "_windows", "at_ns", "axis", "brake", "chain",
        "controller", "cycle_steps", "diagnosis", "energy", "faults", "inverter_enable", "is_cyclic", "load_nm",
        "motor", "operation_mode", "plate", "runs", "settings", "shaft_offset", "task", "true_motor",
    )  # fmt: skip

    def __init__(
        self,
        clock: Clock,
        settings: Mc4Settings,
        table: IdnTable,
        on_change: Callable[[], None],
        true_motor: MotorData | None = None,
    ) -> None:
        """`on_change` is called after each `look`, which may have changed what others see.

        `true_motor` is the motor that is connected, regardless of its plate; None takes it from the plate.
        """
        self._clock, self.settings, self._table = clock, settings, table
        self._on_change = on_change
        self.plate = PlateReader(lambda: self._is_plate_bad, lambda: self.shaft_at(clock.now_ns()))
        self.chain = EnableChain(_times_of(settings), self._on_limit)
        self.diagnosis = Diagnosis(self._on_error, settings.classes, settings.language)
        self._causes = Causes(self.diagnosis)
        self.faults = DriveFaults(clock, MODELS, Faults(Fault), on_change=self._on_faults)
        self.task, self.brake = AxisTask(), Brake()
        self.motor: MotorData | None = None
        """The motor according to its plate; None while it is unknown, so that nothing can be enabled."""
        self.cycle_steps = 16
        self.is_cyclic = False
        """True if the ring is in operation; then the ring side advances the axis once per cycle."""
        self.inverter_enable = settings.inverter_enable
        self.controller = False
        self.runs = True
        """False while the master halts the drive."""
        self.operation_mode = table[std.PRIMARY_MODE].number
        self.load_nm = 0.0
        self.at_ns = clock.now_ns()
        self._is_motor_given = true_motor is not None
        self.shaft_offset = 0.0
        """Increments from the drive's position to the true position of the shaft."""
        motor = true_motor or MotorData()
        self.energy = Energy(clock, settings, self._thermal_of(motor))
        self._build(motor)
        self.axis.put(round(settings.initial_turns * INCREMENTS_PER_TURN))

    # ---- motor and loops

    def start(self) -> None:
        self.at_ns = self._clock.now_ns()
        self.energy.begin()
        for fault in self.settings.faults:
            self.faults.add(fault)
        if self.settings.simulated:
            self.energy.dc.volt = self.energy.dc.full_v
            self._adopt(Plate(MotorData(), 0, self.shaft_increments))
            self.look()
        else:
            self.read_plate()

    def read_plate(self, done: Callable[[bool], None] = lambda is_good: None) -> None:
        """Read the name plate; `done` is called with True once the motor is known.  A simulated drive reads none."""
        if self.settings.simulated:
            done(True)
            return

        def on_read(plate: Plate | Code) -> None:
            if isinstance(plate, Plate):
                self._adopt(plate)
            else:
                self.motor = None
                idns.show_motor(self._table, None)
                self.diagnosis.raise_(plate, stays=True)
            self.look()
            done(isinstance(plate, Plate))

        self.plate.read(on_read)

    @property
    def lacks_plate(self) -> bool:
        """True if the plate or the position could not be read and the message is still pending."""
        return self.motor is None and not {Code.ENCODER_MEMORY, Code.ENCODER_SIGNAL}.isdisjoint(self.diagnosis.pending)

    @property
    def _is_plate_bad(self) -> bool:
        return self.faults.first(EncoderMemory) is not None or self.faults.first(WrongMotor) is not None

    def _adopt(self, plate: Plate) -> None:
        """Recognize the motor (manual 520)."""
        motor = plate.motor
        self.diagnosis.end(Code.ENCODER_MEMORY)
        if self.faults.first(EncoderSignal) is None:
            self.diagnosis.end(Code.ENCODER_SIGNAL)
        self.motor = motor
        idns.show_motor(self._table, motor)
        tuning.tune(self._table, self.settings, motor)
        self.catch_up()
        shaft = self.shaft_increments
        if self._is_motor_given:
            self.rearrange()
        else:
            self._build(motor)
        self._place(plate, shaft)

    def _place(self, plate: Plate, shaft: float) -> None:
        """Set the absolute position: the encoder reports steps, its analog signals give the rest."""
        span, asked_at = plate.motor.range_turns * INCREMENTS_PER_TURN, round(plate.asked_at)
        position = (plate.increments + span // 2) % span - span // 2
        finer = (asked_at - position + span // 2) % span - span // 2
        if abs(finer) <= STEP:
            position += finer
        position += round(shaft) - asked_at  # the shaft has turned since the encoder was asked
        self.axis.put(position)
        self.shaft_offset = shaft - position

    @property
    def shaft_increments(self) -> float:
        """True position of the shaft; the encoder may have an offset from it."""
        return self.axis.position + self.shaft_offset

    @property
    def present(self) -> Moment:
        """The axis at this instant.  Reading it changes nothing."""
        return self.axis.ahead(self._clock.now_ns() - self.at_ns)

    @property
    def present_shaft(self) -> Moment:
        """The axis at this instant, with the true position of the shaft."""
        present = self.present
        return present._replace(position=present.position + self.shaft_offset)

    @property
    def present_dc(self) -> DcCircuit:
        """The DC circuit at this instant, as a copy."""
        return self.energy.dc_now(self.axis, self.at_ns)

    @property
    def present_thermal(self) -> Thermal:
        """The temperatures and loads at this instant, as a copy."""
        return self.energy.thermal_now(self.axis, self.at_ns)

    def switch_mains(self, is_on: bool) -> None:
        """Connect all phases of this drive's supply, or none."""
        self.catch_up()
        self.look_at_slow_things()
        self.energy.dc.is_mains_on = is_on
        self._check_causes()
        self.look()

    def shaft_at(self, now_ns: int) -> float:
        """Return the true position of the shaft at any instant."""
        self.catch_up()
        return self.shaft_increments + self.axis.v * INCREMENTS * (now_ns - self.at_ns) / 1e9

    def _build(self, motor: MotorData) -> None:
        """Build the plant with this motor."""
        load, settings = self.settings.load, self.settings
        self.true_motor = motor
        kind = IdealAxis if settings.simulated else Axis
        self.axis = kind(
            *self._constants, dry_nm=load.coulomb_nm, brake_nm=motor.brake_torque_nm, cycle_steps=self.cycle_steps
        )
        self.axis.load((load.torque_nm + self.load_nm) / load.gear_ratio)
        self.energy.thermal = self._thermal_of(motor)
        self.rearrange()

    def _thermal_of(self, motor: MotorData) -> Thermal:
        amplifier_nm = self.settings.amplifier.continuous_current_a * motor.torque_constant_nm_per_a
        return Thermal(motor.standstill_torque_nm, amplifier_nm, motor.winding_limit_c, motor.thermal_time_s)

    def rearrange(self) -> None:
        """Call this when parameters have changed."""
        table = self._table
        self._windows = Windows(
            table[std.STANDSTILL_WINDOW].number / 1e4 / tuning.RPM,
            table[std.POSITION_WINDOW].number,
            table[std.LOAD_LIMIT].number / 100,
        )
        lead_inertia = tuning.lead_inertia(table, self.settings, self._known) if self._is_lagless else 0.0
        self.axis.arrange(*self._constants, self.cycle_steps, lead_inertia)

    @property
    def _is_lagless(self) -> bool:
        return bool(self.operation_mode & idns.LAGLESS)

    @property
    def _constants(self) -> tuple[Plant, Gains, Limits]:
        """Plant of the true motor; gains and limits from the plate."""
        table, settings, known = self._table, self.settings, self._known
        plant = plant_of(settings.load, self.true_motor)
        gains = tuning.gains_of(table, settings, known, is_lagless=self._is_lagless)
        return plant, gains, tuning.limits_of(table, settings, known)

    @property
    def _known(self) -> MotorData:
        """The motor that the drive assumes."""
        return self.motor or self.true_motor

    def set_load(self, torque_nm: float) -> None:
        """Set the torque at the load, in addition to the configured one."""
        self.catch_up()
        self.load_nm = torque_nm
        self.axis.load((self.settings.load.torque_nm + torque_nm) / self.settings.load.gear_ratio)
        self.look()

    # ---- errors

    def _on_error(self, reaction: Reaction) -> None:
        self.chain.react(self._clock.now_ns(), reaction)

    def _on_limit(self, limit: Limit) -> None:
        self.diagnosis.raise_(LIMITS[limit])

    def fail(self, code: Code) -> None:
        """Report an error whose cause does not persist."""
        if not self.settings.simulated:
            self.diagnosis.raise_(code)
            self.look()

    def quit(self) -> bool:
        """Acknowledge errors; True if none is left."""
        self.catch_up()
        self._check_causes()
        if not self.chain.can_quit:
            return False
        is_good = self.diagnosis.quit()
        if is_good:
            self.chain.quit(self._clock.now_ns())
        self.look()
        return is_good

    def _on_faults(self) -> None:
        """Call this when a fault has begun or ended."""
        self.brake.stick(self.faults.first(StuckBrake), self._clock.now_ns())
        if not self.settings.simulated:
            self._causes.given = given(self.faults)
            self._look_at_plate()
        self.catch_up()
        self._check_causes()
        self.look()

    def _look_at_plate(self) -> None:
        if self._is_plate_bad:
            self.motor = None
            self.diagnosis.raise_(Code.ENCODER_MEMORY, stays=True)
        elif self.lacks_plate:
            self.read_plate()

    def _check_causes(self) -> bool:
        """Update the messages whose cause is visible at any time; True if any has changed."""
        if self.settings.simulated:
            return False
        energy, has_torque = self.energy, self.chain.has_torque
        return self._causes.update(measured(energy.thermal, energy.dc, self._windows.load, has_torque=has_torque))

    # ---- time

    def catch_up(self) -> None:
        """Advance the axis to the present."""
        axis, now_ns = self.axis, self._clock.now_ns()
        if self.is_cyclic and now_ns - self.at_ns < 2 * self.cycle_steps * INNER_NS:
            return  # the ring's cycle advances it
        steps = (now_ns - self.at_ns) // INNER_NS
        if steps > MOST_STEPS:
            self.at_ns = now_ns - MOST_STEPS * INNER_NS
            steps = MOST_STEPS
        if steps > 0:
            self.at_ns += steps * INNER_NS
            axis.go(steps)

    def look(self) -> None:
        """Evaluate enables and speed, and act on them."""
        now_ns = self._clock.now_ns()
        if now_ns >= self.energy.due_ns:
            self.look_at_slow_things()
        self.chain.update(now_ns, self._seen())
        self.task.give(self.axis, self.chain, self.operation_mode & 7 if self.runs else 0)
        self.brake.move(self.axis, self.true_motor, now_ns, is_lifted=self.chain.is_brake_lifted)
        self._on_change()

    def _seen(self) -> Seen:
        axis = self.axis
        return Seen(
            hardware=self.hardware_enable,
            controller=self.controller,
            can_start=self.can_start,
            is_slow=abs(axis.v) < self._windows.standstill,
            is_at_overload_position=abs(axis.position - self.task.overload_position) <= self._windows.position,
        )

    @property
    def hardware_enable(self) -> bool:
        """The input Inverter Enable, as the drive sees it."""
        return self.inverter_enable and self.faults.first(EnableLost) is None

    @property
    def can_start(self) -> bool:
        """Manual 10.1: no error message, DC circuit charged, all phases connected.  The motor has to be known."""
        dc = self.energy.dc
        is_powered = dc.is_charged and dc.is_mains_on and not self._is_dc_dead
        return self.motor is not None and not self.plate.is_reading and is_powered and not self.diagnosis.has_error

    @property
    def _is_dc_dead(self) -> bool:
        return not self.settings.simulated and self.faults.first(DcBus) is not None

    def look_at_slow_things(self) -> bool:
        """Evaluate temperatures, DC circuit and overload; True if a `look` has to follow."""
        has_switched = self.energy.evaluate(self.axis)
        was_told = self.diagnosis.tell_next()
        return self._check_causes() or was_told or has_switched

    @property
    def is_settled(self) -> bool:
        """True if time alone changes nothing but the axis."""
        return self.chain.is_settled and not self.brake.is_moving

    @property
    def is_ready(self) -> bool:
        """True if the ready contact is closed."""
        return self.motor is not None and self.chain.is_ready

    @property
    def follows(self) -> bool:
        return self.chain.stage is Stage.CONTROLLED and self.runs


def _times_of(settings: Mc4Settings) -> Times:
    parameters = settings.parameters
    return Times(
        parameters.brake_disconnection_ms * MS,
        parameters.brake_coupling_ms * MS,
        parameters.stop_time_limit_ms * MS,
        parameters.enable_coast,
        parameters.error_coast,
        parameters.brake_coast,
        parameters.safe_stop_coasts,
    )
