"""The motor of a single drive: loops, power stage, motor, brake, load and encoder, as a CiA 402 axis moves it.

The axis is that of `drives.axis`, in SI units at the shaft of the motor; set values and actual values are increments of
the encoder.  The owner calls `advance` once per cycle, then lets the CiA 402 axis step, and passes its set value to
`follow`.  Mechanical stops block the shaft until the motor turns back.
Left out: the currents, the ripple of the DC link, and the temperature.
"""

from collections.abc import Callable
from math import inf, tau
from typing import Final

from fieldrig.clock import MS, Clock, S
from fieldrig.faults.faults import Fault, Faults
from fieldrig_devices.canopen.node_faults import MODELS as NODE_MODELS
from fieldrig_devices.cia402.motor import Captured, Kind
from fieldrig_devices.cia402.single.faults import (
    MODELS,
    OVERLOAD,
    STO,
    Blocked,
    Cause,
    MainsLost,
    SingleDriveFaults,
    StoOpen,
    StuckBrake,
    Warned,
    causes,
)
from fieldrig_devices.cia402.single.settings import Cia402DriveSettings
from fieldrig_devices.cia402.single.terminals import Inputs
from fieldrig_devices.drives.axis import CREEP, Axis, Mode, Moment
from fieldrig_devices.drives.load import all_inertia, bandwidth, plant_of
from fieldrig_devices.drives.loops import INCREMENTS, INNER_NS, INNER_S, RAD, Gains, Limits, most_way_of
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN

RPM: Final = 60 / tau
SET_BRAKE: Final = 0x1
"""Bit of 60FEh that applies the brake."""
FIRST_OUTPUT: Final = 16


class Servo:
    """The `cia402.motor.Motor` of a single drive."""

    kinds = frozenset(Kind)
    is_there = True
    is_stopping = False

    def __init__(self, clock: Clock, settings: Cia402DriveSettings, inputs: Inputs) -> None:
        self._clock, self._settings, self._terminals = clock, settings, inputs
        self._data = settings.motor.data()
        self._cycle_ns = settings.cycle_us * 1_000
        self.revolution = settings.increments
        self._scale = self.revolution / INCREMENTS_PER_TURN
        self._gear = settings.load.gear_ratio
        low, high = settings.stops
        self._stops = low * self._gear * INCREMENTS, high * self._gear * INCREMENTS
        self._stopped = 0
        """The direction of the mechanical stop at which the shaft is; 0 if it is at none."""
        self._most_nm = self._data.peak_torque_nm
        self._rated_nm, self._rated_a = self._data.rated_torque_nm, self._data.rated_current_a
        """The torque and current of 100 %."""
        self.axis = self._make_axis()
        self.at_ns = clock.now_ns()
        """The instant of the last cycle."""
        self.load_nm = 0.0
        """The torque at the load from outside, in addition to that of the settings."""
        self._is_blocked = False
        self.sto = settings.sto
        self.is_mains_on = True
        self._sto_faults = settings.manner.sto_faults
        self._following_error_code = settings.chosen_behaviour().following_error_code
        self.faults = SingleDriveFaults(clock, {**MODELS, **NODE_MODELS}, Faults(Fault), on_change=self._on_faults)
        self._errors: dict[Cause, None] = {}
        """Errors that have not been reset, the first one first."""
        self._overload = 0.0
        """Share of the heat that the motor bears, 1 at its end."""
        self._look_at_sto()
        self._is_on = self._holds_brake = False
        self._lifted_ns: int | None = None
        self.is_following = self.has_warning = False
        self.is_changed = True
        """True if the state has changed since the last cycle of the CiA 402 axis."""
        self.position, self.velocity, self.torque = 0, 0.0, 0
        self.inputs = 0
        self.on_change: Callable[[], None] = lambda: None
        """Called when something outside the cycle has changed."""
        self._measure()

    def _make_axis(self) -> Axis:
        settings = self._settings
        axis = Axis(
            plant_of(settings.load, self._data),
            self._gains(),
            self._limits(),
            dry_nm=settings.load.coulomb_nm,
            brake_nm=self._data.brake_torque_nm,
            increments=round(settings.initial_position_rad * self._gear * INCREMENTS),
            cycle_steps=self._cycle_ns // INNER_NS,
        )
        axis.load(settings.load.torque_nm / self._gear)
        return axis

    def _gains(self) -> Gains:
        loops, load = self._settings.loops, self._settings.load
        kp = all_inertia(load, self._data) * bandwidth(load)
        seconds = loops.integral_time_ms / 1_000
        return Gains(loops.position_gain_per_s, kp, kp / seconds if seconds else 0.0, loops.speed_feed_forward)

    def _limits(self) -> Limits:
        return Limits(max(self._most_nm, 1e-6), self._data.max_speed_rpm / RPM)

    # ---- actual values

    def _measure(self) -> None:
        axis = self.axis
        self.position = round(axis.position * self._scale)
        self.velocity = axis.v / tau * self.revolution
        self.torque = round(axis.t / self._rated_nm * 1_000)
        self.inputs = self._terminals.word(axis.position * RAD / self._gear)

    @property
    def present(self) -> Moment:
        """The axis at this instant."""
        moment = self.axis.ahead(self._clock.now_ns() - self.at_ns)
        low, high = self._stops
        return moment._replace(position=min(max(moment.position, low), high))

    @property
    def load_position(self) -> float:
        """The position of the load at this instant, in rad."""
        moment = self.present
        return (moment.position * RAD - moment.twist) / self._gear

    def rate(self, torque_nm: float | None, current_a: float | None, by_current: bool) -> None:
        """Set the rated values that the objects say; None for those of the motor.

        With `by_current` the rated torque is the one of the rated current.
        """
        data = self._data
        self._rated_a = data.rated_current_a if current_a is None else current_a
        if by_current:
            self._rated_nm = self._rated_a * data.torque_constant_nm_per_a
        else:
            self._rated_nm = data.rated_torque_nm if torque_nm is None else torque_nm
        self._measure()

    @property
    def current(self) -> int:
        """In 0.1 % of the rated current: a synchronous motor has torque in proportion to its current."""
        return round(self.axis.t / self._data.torque_constant_nm_per_a / self._rated_a * 1_000)

    @property
    def torque_by_current(self) -> float:
        return self._rated_a * self._data.torque_constant_nm_per_a / self._rated_nm

    @property
    def rated_torque_mnm(self) -> int:
        return round(self._rated_nm * 1_000)

    @property
    def rated_current_ma(self) -> int:
        return round(self._rated_a * 1_000)

    @property
    def largest_speed(self) -> float:
        steps = self.axis.arrangement.steps
        return most_way_of(self._limits(), steps) / (steps * INNER_S) * self._scale

    @property
    def dc_link_mv(self) -> int:
        return round(self._settings.supply_v * 1_000) if self.has_mains else 0

    @property
    def has_mains(self) -> bool:
        return self.is_mains_on and self.faults.first(MainsLost) is None

    @property
    def may_turn(self) -> bool:
        """True if safe torque off permits a torque."""
        return self.sto and self.faults.first(StoOpen) is None

    @property
    def is_ready(self) -> bool:
        return self.has_mains and self.may_turn

    @property
    def errors(self) -> tuple[int, ...]:
        return tuple(cause.code for cause in self._errors) if self._errors else ()

    @property
    def is_brake_lifted(self) -> bool:
        """True if the drive lifts the holding brake."""
        return self._lifted_ns is not None and not self._holds_brake

    @property
    def is_settled(self) -> bool:
        """True if another cycle would change nothing: without torque, at rest, and with nothing to wait for."""
        return not self._is_on and self.axis.is_at_rest and not self.is_changed

    def captured(self, bit: int) -> Captured | None:
        return self._terminals.captured.get(bit)

    def capture(self) -> Captured:
        """Return position and instant of an edge that comes now."""
        return Captured(round(self.present.position * self._scale), self._clock.now_ns())

    # ---- commands

    def enable(self, is_on: bool) -> None:
        if is_on is self._is_on:
            return
        self._is_on = is_on
        if is_on:
            self.axis.control(Mode.POSITION)
            lift_ns = round(self._data.brake_lift_ms * MS) if self._data.has_brake else 0
            self._lifted_ns = self._clock.now_ns() + lift_ns
            self.is_following = lift_ns == 0 and not self._coasts
        else:
            self._lifted_ns, self.is_following = None, False
            self.axis.control(Mode.FREE)
        self._apply_brake()
        self._change()

    def limit_torque(self, most: int) -> None:
        self._most_nm = min(self._data.peak_torque_nm, most / 1_000 * self._rated_nm)
        arranged = self.axis.arrangement
        self.axis.arrange(arranged.plant, arranged.gains, self._limits(), arranged.steps)

    def set_outputs(self, outputs: int, mask: int) -> None:
        self._holds_brake = bool(outputs & mask & SET_BRAKE)
        self._apply_brake()
        self._terminals.show_outputs((outputs & mask) >> FIRST_OUTPUT)
        self._change()

    def reset(self, done: Callable[[], None]) -> None:
        self._overload = 0.0
        self._errors = dict.fromkeys(causes(self.faults, self._following_error_code))
        self._look_at_sto()
        self._change()
        done()

    def follow(self, kind: Kind, value: float) -> None:
        """Take the set value of this cycle, as `kind` says."""
        if not self.is_following:
            return
        axis = self.axis
        if kind is Kind.POSITION:
            axis.control(Mode.POSITION)
            axis.follow(round(value / self._scale))
        elif kind is Kind.VELOCITY:
            axis.control(Mode.SPEED)
            axis.set_value(value / self.revolution * tau)
        else:
            axis.control(Mode.TORQUE)
            axis.set_value(value / 1_000 * self._rated_nm)

    def cause_of(self, code: int) -> Cause:
        """Return the cause of an error with this code; one that the state machine has found has nothing of its own."""
        return next((cause for cause in self._errors if cause.code == code), Cause(code, coasts=False))

    # ---- the world

    def set_load(self, torque_nm: float) -> None:
        """Set the torque at the load from outside, in N m; positive torque acts backwards."""
        self.load_nm = torque_nm
        self.axis.load((self._settings.load.torque_nm + torque_nm) / self._gear)
        self._change()

    def block(self, is_on: bool) -> None:
        self._is_blocked = is_on
        self._jam()

    @property
    def is_blocked(self) -> bool:
        return self._is_blocked or self.faults.first(Blocked) is not None

    def switch_sto(self, is_on: bool) -> None:
        self.sto = is_on
        self._look()

    def switch_mains(self, is_on: bool) -> None:
        self.is_mains_on = is_on
        self._look()

    def on_input(self) -> None:
        """Take over a change of an input."""
        self.inputs = self._terminals.word(self.axis.position * RAD / self._gear)
        self._change()

    def _on_faults(self) -> None:
        self._errors |= dict.fromkeys(causes(self.faults, self._following_error_code))
        self.has_warning = self.faults.first(Warned) is not None
        self._jam()
        self._apply_brake()
        self._look()

    @property
    def _coasts(self) -> bool:
        return not self.is_ready or any(cause.coasts for cause in self._errors)

    def _look(self) -> None:
        """Switch the torque off at once where the power stage does so."""
        self._look_at_sto()
        if self.is_following and self._coasts:
            self.is_following = False
            self.axis.control(Mode.FREE)
            self._lifted_ns = None
            self._apply_brake()
        self._change()

    def _look_at_sto(self) -> None:
        if self._sto_faults and not self.may_turn:
            self._errors[STO] = None

    def _change(self) -> None:
        self.is_changed = True
        self.on_change()

    def _jam(self) -> None:
        self.axis.jam(self.is_blocked or self._stopped != 0)
        self._change()

    def _apply_brake(self) -> None:
        stuck = self.faults.first(StuckBrake)
        is_applied = not self.is_brake_lifted if stuck is None else stuck.stays == "on"
        self.axis.brake(is_applied and self._data.has_brake)

    # ---- once a cycle

    def advance(self, cycles: int) -> None:
        """Advance to the present instant, which is the end of a cycle; `cycles` have passed since the last call."""
        axis, now_ns = self.axis, self._clock.now_ns()
        for _ in range(cycles):
            if self._stopped:
                self._leave_stop()
            axis.cycle()
            if self._stops != (-inf, inf):
                self._meet_stop()
            if axis.mode is Mode.FREE and not axis.load_nm and abs(axis.v) < CREEP:
                axis.v = 0.0  # what is slower than an increment per second stands, as dry friction has it
        self.at_ns = now_ns
        if self._lifted_ns is not None and not self.is_following and now_ns >= self._lifted_ns and not self._coasts:
            self.is_following = self.is_changed = True
        self._heat(cycles)
        self._measure()

    def _heat(self, cycles: int) -> None:
        """I2t: the torque beyond the rated one is borne for a time that depends on its square."""
        seconds = cycles * self._cycle_ns / S
        square, _ = self.axis.take(seconds)
        rated = self._data.rated_torque_nm
        excess = square / rated**2 - 1
        most = (self._data.peak_torque_nm / rated) ** 2 - 1
        self._overload = max(self._overload + excess * seconds / (max(most, 1e-3) * self._settings.motor.overload_s), 0)
        if self._overload >= 1 and OVERLOAD not in self._errors:
            self._errors[OVERLOAD] = None
            self.is_changed = True

    def _meet_stop(self) -> None:
        low, high = self._stops
        position = self.axis.position
        if position > high or position < low:
            self._stopped = 1 if position > high else -1
            self.axis.jam(is_on=True, at=high if position > high else low)

    def _leave_stop(self) -> None:
        """Release the shaft once the torque pulls it back from the stop."""
        if (self.axis.t - self.axis.load_nm) * self._stopped < -self._settings.load.coulomb_nm:
            self._stopped = 0
            self._jam()
