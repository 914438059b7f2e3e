"""The drive behind its ring interface: enable chain, diagnosis, axis, DC circuit and temperatures together.

Source: manual chapter 10 and 513-540; digest 1.5, 1.8, 1.9.  This module does not know
the ring: the ring side sets `controller` and so on, advances the axis, and calls `look` when something may have
changed.  Temperatures, DC circuit and overload are evaluated every 64 ms.
"""

from collections.abc import Callable
from copy import copy
from typing import Final

from fieldrig.clock import MS, Clock
from fieldrig.faults.faults import Fault, Faults
from fieldrig_devices.drives.axis import Axis, IdealAxis, Mode, Moment
from fieldrig_devices.drives.load import plant_of
from fieldrig_devices.drives.loops import INCREMENTS, INNER_NS, Gains, Limits, Plant
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN, Encoder, MotorData
from fieldrig_devices.mc4 import idns, tuning
from fieldrig_devices.mc4.causes import CAUSES, given, measured
from fieldrig_devices.mc4.diagnosis import LIMITS, Code, Diagnosis
from fieldrig_devices.mc4.enable import EnableChain, Limit, Reaction, Seen, Stage, Task, Times
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
from fieldrig_devices.mc4.power import DcCircuit
from fieldrig_devices.mc4.settings import Mc4Settings
from fieldrig_devices.mc4.thermal import Thermal
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.datum import IdnTable

SLOW_NS: Final = 64 * MS
"""Interval at which temperatures, DC circuit and overload are evaluated."""
MOST_STEPS: Final = 4_000
"""Largest number of inner steps to catch up with; after a pause of more than a second, the rest is skipped."""
SPREAD_NS: Final = 23 * MS
"""Offset of the slow evaluation from one ring address to the next: any 64 consecutive addresses use other cycles."""
STEP: Final = 31
"""Resolution of the encoder's serial position, in increments."""


class Machine:
    """A drive with its motor, without its ring interface."""

    __slots__ = (
        "_brake_due_ns", "_brake_stuck", "_causes", "_clock", "_given", "_held_in", "_hidden", "_is_dc_dead",
        "_is_enable_lost", "_is_motor_given", "_load_limit", "_on_change", "_readings", "_shown_mode", "_slow_due_ns",
        "_slow_ns", "_standstill", "_table", "_task", "_was_relay", "_window", "at_ns", "axis", "chain",
        "controller", "cycle_steps", "dc", "diagnosis", "enable_bit", "encoder", "faults", "inverter_enable",
        "is_cyclic", "load_nm", "motor", "operation_mode", "overload_position", "runs", "settings",
        "shaft_offset", "thermal", "times", "true_motor",
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
        self.encoder: Encoder | None = None
        """The encoder; it has to be set before `start`."""
        self._on_change = on_change
        parameters = settings.parameters
        self.times = Times(
            parameters.brake_disconnection_ms * MS,
            parameters.brake_coupling_ms * MS,
            parameters.stop_time_limit_ms * MS,
            parameters.enable_coast,
            parameters.error_coast,
            parameters.brake_coast,
            parameters.safe_stop_coasts,
        )
        self.chain = EnableChain(self.times, self._on_limit)
        self.diagnosis = Diagnosis(self._on_error, settings.classes, settings.language)
        self._hidden: list[Code] = []
        """Messages that the controller has yet to see, as they have not become the DiagCode."""
        self.diagnosis.on_hidden = self._hidden.append
        self.faults = DriveFaults(clock, MODELS, Faults(Fault), on_change=self._on_faults)
        self.dc = DcCircuit(settings.amplifier.mains_v)
        self.motor: MotorData | None = None
        """The motor according to its plate; None while it is unknown, so that nothing can be enabled."""
        self.cycle_steps = 16
        self.is_cyclic = False
        """True if the ring is in operation; then the ring side advances the axis once per cycle."""
        self.inverter_enable = settings.inverter_enable
        self.controller = False
        self.enable_bit = True
        self.runs = True
        """False while the master halts the drive."""
        self.operation_mode = table[std.PRIMARY_MODE].number
        self.load_nm = 0.0
        self.overload_position = 0
        self._task = Task.NOTHING
        self._held_in: Stage | None = None
        self._shown_mode = 0
        self._brake_due_ns: int | None = None
        self._was_relay = False
        self._brake_stuck: StuckBrake | None = None
        self._slow_ns = self.at_ns = clock.now_ns()
        self._slow_due_ns = self._slow_ns + SLOW_NS
        self._is_dc_dead = self._is_enable_lost = False
        self._readings = 0
        """Number of name plate readings in progress."""
        self._given = self._causes = 0
        self._is_motor_given = true_motor is not None
        self.shaft_offset = 0.0
        """Increments from the drive's position to the true position of the shaft."""
        self._build(true_motor or MotorData())
        self.axis.put(round(settings.initial_turns * INCREMENTS_PER_TURN))

    # ---- motor and loops

    def start(self) -> None:
        self._slow_ns = self.at_ns = self._clock.now_ns()
        for fault in self.settings.faults:
            self.faults.add(fault)
        if self.settings.simulated:
            self.dc.volt = self.dc.full_v
            self._adopt(MotorData(), 0, self.shaft_increments)
            self.look()
        else:
            self.read_plate()

    def read_plate(self, done: Callable[[bool], None] = lambda is_good: None) -> None:
        """Read the name plate; `done` is called with True once the motor is known.  A simulated drive reads none."""
        if self.settings.simulated:
            done(True)
            return
        encoder = self.encoder
        assert encoder is not None
        self._readings += 1
        asked_at = 0.0

        def end(is_good: bool) -> None:
            self._readings -= 1
            self.look()
            done(is_good)

        def fail(code: Code) -> None:
            self.motor = None
            idns.show_motor(self._table, None)
            self.diagnosis.raise_(code, stays=True)
            end(False)

        def on_asked() -> None:
            nonlocal asked_at
            asked_at = self.shaft_at(self._clock.now_ns())

        def on_plate(motor: MotorData | None) -> None:
            if motor is None or self._is_plate_bad:
                fail(Code.ENCODER_MEMORY)
            else:
                encoder.read_position(lambda increments: on_position(motor, increments), on_asked)

        def on_position(motor: MotorData, increments: int | None) -> None:
            if self._is_plate_bad:  # a fault may have been added meanwhile
                fail(Code.ENCODER_MEMORY)
            elif increments is None:
                fail(Code.ENCODER_SIGNAL)
            else:
                self._adopt(motor, increments, asked_at)
                end(True)

        encoder.read_plate(on_plate)

    @property
    def lacks_plate(self) -> bool:
        """True if the plate or the position could not be read and the message is still pending."""
        return self.motor is None and not {Code.ENCODER_MEMORY, Code.ENCODER_SIGNAL}.isdisjoint(self.diagnosis.pending)

    @property
    def _is_plate_bad(self) -> bool:
        return self.faults.first(EncoderMemory) is not None or self.faults.first(WrongMotor) is not None

    def _adopt(self, motor: MotorData, increments: int, asked_at: float) -> None:
        """Recognize the motor (manual 520).  The encoder reported `increments` when the shaft was at `asked_at`."""
        self.diagnosis.end(Code.ENCODER_MEMORY)
        if self.faults.first(EncoderSignal) is None:
            self.diagnosis.end(Code.ENCODER_SIGNAL)
        self.motor = motor
        idns.show_motor(self._table, motor)
        tuning.tune(self._table, self.settings, motor)
        self.catch_up()
        true = self.shaft_increments
        if self._is_motor_given:
            self.rearrange()
        else:
            self._build(motor)
        self._place(increments, motor.range_turns * INCREMENTS_PER_TURN, asked_at, true)

    def _place(self, increments: int, span: int, asked_at: float, true: float) -> None:
        """Set the absolute position: the encoder reports steps, its analog signals give the rest."""
        position = (increments + span // 2) % span - span // 2
        finer = (round(asked_at) - position + span // 2) % span - span // 2
        if abs(finer) <= STEP:
            position += finer
        position += round(true) - round(asked_at)
        self.axis.put(position)
        self.shaft_offset = true - position

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
        dc, (seconds, _, work) = copy(self.dc), self._since_slow
        if not self.settings.simulated:
            dc.go(seconds, work)
        return dc

    @property
    def present_thermal(self) -> Thermal:
        """The temperatures and loads at this instant, as a copy."""
        thermal, (seconds, heat, _) = copy(self.thermal), self._since_slow
        if not self.settings.simulated:
            thermal.go(seconds, heat)
        return thermal

    @property
    def _since_slow(self) -> tuple[float, float, float]:
        """Seconds since `look_at_slow_things`, and the result of `Axis.take` for them."""
        heat, work = copy(self.axis).take((self.at_ns - self._slow_ns) / 1e9)
        return (self._clock.now_ns() - self._slow_ns) / 1e9, heat, work

    def switch_mains(self, is_on: bool) -> None:
        """Connect all phases of this drive's supply, or none."""
        self.catch_up()
        self.look_at_slow_things()
        self.dc.is_mains_on = is_on
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
        amplifier_nm = settings.amplifier.continuous_current_a * motor.torque_constant_nm_per_a
        self.thermal = Thermal(motor.standstill_torque_nm, amplifier_nm, motor.winding_limit_c, motor.thermal_time_s)
        self.rearrange()

    def rearrange(self) -> None:
        """Call this when parameters have changed."""
        table = self._table
        self._standstill = table[std.STANDSTILL_WINDOW].number / 1e4 / tuning.RPM
        self._window = table[std.POSITION_WINDOW].number
        self._load_limit = table[std.LOAD_LIMIT].number / 100
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

    @property
    def diagnostic_number(self) -> int:
        """S-0-0390: the DiagCode; for some cycles a new message beside it, so that the controller's log has all."""
        return int(self._hidden[0] if self._hidden else self.diagnosis.code)

    def quit(self) -> bool:
        """Acknowledge errors; True if none is left."""
        self.catch_up()
        self._check_causes()
        if not self.chain.can_quit:
            return False
        is_good = self.diagnosis.quit()
        if is_good:
            self._hidden.clear()
            self.chain.quit(self._clock.now_ns())
        self.look()
        return is_good

    def _on_faults(self) -> None:
        """Call this when a fault has begun or ended."""
        faults = self.faults
        stuck = faults.first(StuckBrake)
        if stuck is not self._brake_stuck:
            self._brake_stuck = stuck
            self._brake_due_ns = self._clock.now_ns()
        self._is_enable_lost = faults.first(EnableLost) is not None
        if not self.settings.simulated:
            self._given = given(self.faults)
            self._is_dc_dead = faults.first(DcBus) is not None
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
        causes = self._given
        if not self.settings.simulated:
            causes |= measured(self.thermal, self.dc, self._load_limit, has_torque=self.chain.has_torque)
        changed, self._causes = causes ^ self._causes, causes
        for place, code in enumerate(CAUSES) if changed else ():
            if changed >> place & 1:
                if causes >> place & 1:
                    self.diagnosis.raise_(code, stays=True)
                else:
                    self.diagnosis.end(code)
        return bool(changed)

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

    @property
    def next_slow_ns(self) -> int:
        return self._slow_due_ns

    def look(self) -> None:
        """Evaluate enables and speed, and act on them."""
        now_ns = self._clock.now_ns()
        if now_ns >= self._slow_due_ns:
            self.look_at_slow_things()
        self.chain.update(now_ns, self._seen())
        self._give_task()
        self._move_brake(now_ns)
        self._on_change()

    def _seen(self) -> Seen:
        axis = self.axis
        return Seen(
            hardware=self.hardware_enable,
            controller=self.controller,
            can_start=self.can_start,
            is_slow=abs(axis.v) < self._standstill,
            is_at_overload_position=abs(axis.position - self.overload_position) <= self._window,
        )

    @property
    def hardware_enable(self) -> bool:
        """The input Inverter Enable, as the drive sees it."""
        return self.inverter_enable and not self._is_enable_lost

    @property
    def can_start(self) -> bool:
        """Manual 10.1: no error message, DC circuit charged, all phases connected.  The motor has to be known."""
        is_powered = self.dc.is_charged and self.dc.is_mains_on and not self._is_dc_dead
        return self.motor is not None and not self._readings and is_powered and not self.diagnosis.has_error

    def look_at_slow_things(self) -> bool:
        """Evaluate temperatures, DC circuit and overload; True if a `look` has to follow."""
        now_ns = self._clock.now_ns()
        seconds = (now_ns - self._slow_ns) / 1e9
        self._slow_ns = now_ns
        self._slow_due_ns = now_ns + SLOW_NS - (now_ns - self.settings.ring_address * SPREAD_NS) % SLOW_NS
        heat, work = self.axis.take(seconds)
        was_told = bool(self._hidden and self._hidden.pop(0))
        if self.settings.simulated:
            return was_told
        was_charged = self.dc.is_charged
        self.thermal.go(seconds, heat)
        self.dc.go(seconds, work)
        return self._check_causes() or was_told or was_charged is not self.dc.is_charged

    def _give_task(self) -> None:
        task, axis = self.chain.task, self.axis
        if task is Task.FOLLOW:
            mode = self.operation_mode & 7 if self.runs else 0
            if self._task is not task or mode != self._shown_mode:
                self._shown_mode = mode
                axis.control({1: Mode.TORQUE, 2: Mode.SPEED, 3: Mode.POSITION}.get(mode, Mode.SPEED))
                axis.set_value(0.0)
        elif task is not self._task or (task is Task.HOLD and self.chain.stage is not self._held_in):
            self._held_in = self.chain.stage
            if task is Task.HOLD:
                if self.chain.stage is not Stage.OVERLOAD_HELD:
                    axis.control(Mode.POSITION)
                    axis.hold_here()
                    self.overload_position = axis.set_increments
            else:
                axis.control(Mode.FREE if task is Task.NOTHING else Mode.SPEED)
                axis.set_value(0.0)
        self._task = task

    def _move_brake(self, now_ns: int) -> None:
        """Let the brake follow its relay with its own delay, unless it is stuck."""
        relay = self.chain.is_brake_lifted
        motor = self.true_motor
        if relay is not self._was_relay:
            self._was_relay = relay
            delay_ms = motor.brake_lift_ms if relay else motor.brake_drop_ms
            self._brake_due_ns = now_ns + round(delay_ms * MS)
        if self._brake_due_ns is not None and now_ns >= self._brake_due_ns:
            self._brake_due_ns = None
            stuck = self._brake_stuck
            self.axis.brake(motor.has_brake and (not relay if stuck is None else stuck.stays == "on"))

    @property
    def is_settled(self) -> bool:
        """True if time alone changes nothing but the axis."""
        return self.chain.is_settled and self._brake_due_ns is None

    @property
    def is_ready(self) -> bool:
        """True if the ready contact is closed."""
        return self.motor is not None and self.chain.is_ready

    @property
    def follows(self) -> bool:
        return self.chain.stage is Stage.CONTROLLED and self.runs
