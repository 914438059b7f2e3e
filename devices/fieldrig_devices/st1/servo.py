"""The axis of an ST1: set position, shaft, power stage and errors together, without the ring and without the wires.

Source: PAM manual 1084-1150, 6712-6993, 8770-9075 (digests: PAML-040 to PAML-065, PAMS-010 to PAMS-018, PAMS-049,
PAMS-055).  The manual says what an axis is asked and what it answers; how it reacts to its errors is our choice, and a
setting: some switch the power stage off, and a ring that breaks stops the axis.  An order that needs power while it is
off is refused with POWER_STAGE_DISABLED, which another setting shows as long as the power is off (G-15).
"""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import Alarm, Clock
from fieldrig.shortcuts import Shortcut
from fieldrig_bus.wires import Signal
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.pamring.axis_words import Error
from fieldrig_devices.pamring.frames import AxisItem, AxisOrder, AxisReport, EndOfPipe, Move, SetPoint, SetPointMode
from fieldrig_devices.st1.answers import Answers, status_of
from fieldrig_devices.st1.causes import Causes
from fieldrig_devices.st1.outer_shaft import shaft_of
from fieldrig_devices.st1.set_position import Doing, SetPosition
from fieldrig_devices.st1.settings import St1Settings
from fieldrig_devices.st1.shaft import TURN
from fieldrig_devices.st1.status import ErrorWord
from fieldrig_devices.st1.torque import Torque

STEADY: Final = Shortcut(
    "st1.steady", "a set-point that the shaft follows as before is not an event for all of the axis"
)


class Servo:
    __slots__ = (
        "_clock", "_is_off_due", "_is_off_shown", "_is_ring_dead", "_may_be_steady", "_postponed", "_timer", "_trips",
        "answers", "causes", "errors", "is_powered", "on_change", "on_steady", "refer", "set", "settings", "shaft",
        "torque",
    )  # fmt: skip

    def __init__(self, clock: Clock, settings: St1Settings, send: Callable[[AxisReport], None]) -> None:
        self._clock, self.settings = clock, settings
        own = settings.parameters
        self.set = SetPosition(Limits(own.ckv * TURN, own.cka * TURN, own.astop * TURN))
        self.torque = Torque(settings.motor)
        self.shaft = shaft_of(settings, self.set, self.torque, lambda volts: self.refer(volts))
        self.errors = ErrorWord(own.cmasks)
        self._trips = settings.readings.tripping
        self._is_off_shown = settings.readings.power_stage_disabled == "off"
        self.causes = Causes(clock, settings, self._on_causes)
        self.answers = Answers(send)
        self.on_change: Callable[[], None] = lambda: None
        """Called when the motion of the shaft has changed."""
        self.on_steady: Callable[[int], None] = lambda now_ns: None
        """Called at each set-point of a pipe that the shaft follows, as long as nothing else moves it."""
        self.refer: Callable[[float], None] = lambda volts: None
        """Called with the reference in volts of a motor on wires."""
        self._may_be_steady = STEADY.is_taken
        self.is_powered = False
        self._is_off_due = self._is_ring_dead = False
        self._postponed: SetPoint | None = None
        """The last set-point that came during a stop."""
        self._timer = Alarm(self._clock)
        self.set.hold(clock.now_ns(), round(settings.initial_turns * TURN))
        self.shaft.place(clock.now_ns(), round(settings.initial_turns * TURN))

    def measure(self, encoder: Signal) -> None:
        """Take the encoder of a motor on wires; a shaft that leaves its set position wakes the loop."""
        self.shaft.measure(encoder)
        self._go_on()

    def start(self) -> None:
        for fault in self.settings.faults:
            self.causes.faults.add(fault)
        self._on_causes()

    def now_ns(self) -> int:
        return self._clock.now_ns()

    @property
    def torque_nm(self) -> float:
        """The torque of the motor, in N m."""
        return self.torque.of_rate(self.shaft.effort_at(self._clock.now_ns()))

    # ---- the PAM

    def forget(self) -> None:
        """The PAM begins again: the axis stops, and its power goes off unless a setting keeps it."""
        self.answers.forget()
        if self.is_powered:
            self._brake()
            self._is_off_due = self._is_off_due or self.settings.readings.on_pam_reset == "stop_and_power_off"
        self._go_on()

    def accept(self, item: AxisItem) -> bool:
        """Take the position at power-on of the PAM, without a motion (PAML-043), and the period."""
        if item.position_period < 0:
            return False
        self.answers.is_axis = True
        self.set.period = item.position_period
        self.set.rename(self._clock.now_ns(), item.initial_position)
        self._go_on()
        return True

    def order(self, order: AxisOrder) -> None:
        now_ns, move = self._clock.now_ns(), order.move
        self.answers.begin(order.number)
        if move is Move.POWER_ON:
            self._power_on(now_ns, order.value)
        elif move is Move.POWER_OFF:
            self._power_off(now_ns, order.deceleration)
        elif move is Move.POSITION:
            self.set.rename(now_ns, order.value)
        elif move is Move.UPDATE_STATUS:
            self.errors.clear(Error.CHANGE_IN_CD | Error.POWER_STAGE_DISABLED)
            self.answers.repeat()
        elif self.is_powered and not self._is_off_due:
            if move is Move.STOP:
                self._postponed = None
            self.set.order(now_ns, order)
        elif move is not Move.STOP:
            self.errors.latch(Error.POWER_STAGE_DISABLED)
        self._go_on()

    def set_point(self, point: SetPoint) -> None:
        """Take a value of a pipe.  It counts later if the axis stops, and not at all if there is no power."""
        mode, setting, shaft, now_ns = point.mode, self.set, self.shaft, self._clock.now_ns()
        pipe = setting.pipe
        if pipe.mode is mode and setting.doing is Doing.NOTHING and pipe.is_steady and shaft.is_following:
            before = pipe.speed
            pipe.set_position(now_ns, point.value)
            speed = pipe.speed
            is_short = self._may_be_steady and speed and self._timer.is_set
            if is_short and shaft.keeps_up(before, speed, pipe.interval_ns):
                self.on_steady(now_ns)
                return
        elif mode is SetPointMode.TORQUE:
            self._limit_torque(point.value)
            return
        elif setting.doing is Doing.STOP:
            self._postponed = point
            return
        elif not self.is_powered:
            return
        else:
            before = setting.speed_at(now_ns)
            setting.set_point(now_ns, mode, point.value)
        shaft.look(now_ns, before)
        self._go_on()

    def end_of_pipe(self, end: EndOfPipe) -> None:
        if end.mode is SetPointMode.TORQUE:
            self._limit_torque(1000)
        else:
            self._postponed = None
            self.set.end_of_pipe(self._clock.now_ns(), end.mode)
            self._go_on()

    def cycle(self) -> None:
        """End what the last set-point began, if no other has come; there is nothing to do for an axis at rest."""
        pipe = self.set.pipe
        if pipe.mode is None:
            if self.causes.has_range and self.set.is_moving:
                self._look_at_limits()
            return
        now_ns = self._clock.now_ns()
        if now_ns >= pipe.due_ns:
            before = self.set.speed_at(now_ns)
            pipe.settle(now_ns)
            self.shaft.look(now_ns, before)
            self._go_on()
        elif pipe.is_ending:
            self._go_on()
        if self.causes.has_range:
            self._look_at_limits()

    def ring(self, is_dead: bool, is_faulty: bool) -> None:
        """Take the state of the ring: a dead one stops the axis."""
        self.causes.put_ring(is_faulty)
        if is_dead and not self._is_ring_dead and self.is_powered:
            self._brake()
            self._is_off_due = self._is_off_due or self.settings.on_ring_fault == "stop_and_power_off"
        self._is_ring_dead = is_dead
        self._on_causes()

    # ---- power

    def _power_on(self, now_ns: int, position: int) -> None:
        """Switch the power on; the position gets the name that the PAM gives, without a motion (PAML-055)."""
        self._is_off_due = False
        self.errors.clear(~Error.CHANGE_IN_CD)
        if self.errors.present & self._trips or self._is_ring_dead:
            self.errors.latch(Error.POWER_STAGE_DISABLED)
            return
        if not self.is_powered:
            self.set.hold(now_ns, self.shaft.position_at(now_ns))
            self.is_powered = True
            self.shaft.power(now_ns, True)
        self.set.rename(now_ns, position)

    def _power_off(self, now_ns: int, deceleration: int) -> None:
        """Stop first if the axis moves (PAML-056)."""
        if self.is_powered:
            if self.set.is_moving or self.set.pipe.mode is not None:
                self._brake(deceleration)
            self._is_off_due = True

    def _brake(self, deceleration: int = 0) -> None:
        """Stop, also what a set-point during an earlier stop would begin."""
        self._postponed = None
        self.set.stop(self._clock.now_ns(), deceleration)

    def _cut(self, now_ns: int) -> None:
        """Take the power off at once; the motor coasts."""
        self.shaft.power(now_ns, False)
        self.is_powered = self._is_off_due = False
        self.set.hold(now_ns, self.shaft.position_at(now_ns))

    # ---- causes of errors

    def put(self, bit: Error, is_on: bool) -> None:
        """Take a cause of an error from a wire."""
        self.causes.put(bit, is_on)
        self._on_causes()

    def switch(self, is_on: bool) -> None:
        """Take the input `enable`."""
        self.causes.enable = is_on
        self._on_causes()

    def load(self, load_nm: float) -> None:
        """Take the torque at the load."""
        self.torque.load_nm = load_nm
        self._on_torque()

    def _limit_torque(self, thousandths: int) -> None:
        self.torque.limit = min(max(thousandths, 0), 1000) / 1000
        self._on_torque()

    def _on_torque(self) -> None:
        if self.torque.acceleration != self.shaft.acceleration:
            self.shaft.acceleration, self.shaft.friction = self.torque.acceleration, self.torque.coasting
            self.shaft.look(self._clock.now_ns())
            self._go_on()

    def _on_causes(self) -> None:
        now_ns = self._clock.now_ns()
        if self.causes.is_jammed is not self.shaft.is_blocked:
            self.shaft.block(now_ns, self.causes.is_jammed)
        self._go_on()

    def _present(self, now_ns: int) -> int:
        """Return the bits of all causes of errors."""
        bits = self.causes.bits
        if self.shaft.is_limited_at(now_ns):
            bits |= Error.CURRENT_LIMITED
        if self._is_out(now_ns):
            bits |= Error.OUT_OF_LIMITS
        return bits

    def _is_out(self, now_ns: int) -> bool:
        return self.causes.has_range and self.causes.is_out(self.set.named(self.shaft.position_at(now_ns)))

    def _look_at_limits(self) -> None:
        if self._is_out(self._clock.now_ns()) is not bool(self.errors.present & Error.OUT_OF_LIMITS):
            self._go_on()

    # ---- time

    def _on_timer(self) -> None:
        now_ns, pipe = self._clock.now_ns(), self.set.pipe
        if now_ns >= pipe.lost_ns:
            self.shaft.leave(now_ns)
            pipe.hold(now_ns)
            self._go_on()
        elif self._may_be_steady and pipe.is_steady and now_ns < self.shaft.next_ns and self.set.doing is Doing.NOTHING:
            self._wait(now_ns)  # further set-points have come
        else:
            self._go_on()

    def _go_on(self) -> None:
        """Look at everything after an event, report what has changed, and wait for the next instant of interest."""
        now_ns = self._clock.now_ns()
        self._end_motions(now_ns)
        self.shaft.look(now_ns)
        if abs(self.shaft.lag_at(now_ns)) > self.settings.lag_limit_turns * TURN:
            self.errors.latch(Error.SERVO_LAG_ERROR)
        self.errors.put(self._present(now_ns))
        if self.is_powered and (self.errors.present | self.errors.value & Error.SERVO_LAG_ERROR) & self._trips:
            self._cut(now_ns)
        if self._is_off_shown:
            self.errors.shown = 0 if self.is_powered else Error.POWER_STAGE_DISABLED
        self.answers.waits = self._is_off_due or (self.set.is_own_moving and not self.set.is_done(now_ns))
        self.report()
        self.on_change()
        self._wait(now_ns)
        if self._postponed is not None and self.set.doing is not Doing.STOP:
            point, self._postponed = self._postponed, None
            self.set_point(point)

    def _end_motions(self, now_ns: int) -> None:
        self.set.finish(now_ns)
        if not self.is_powered:
            self.set.hold(now_ns, self.shaft.position_at(now_ns))
        if self._is_off_due and not self.set.is_moving:
            self._cut(now_ns)

    def _wait(self, now_ns: int) -> None:
        when_ns = self.shaft.next_ns
        if self.set.is_moving:
            when_ns = min(when_ns, self.set.next_change_ns(now_ns), self.set.pipe.lost_ns)
        self._timer.at(when_ns, self._on_timer)

    # ---- the report

    @property
    def status(self) -> int:
        needs_stop = self.settings.readings.stopped == "after_stop"
        return status_of(self.set, is_powered=self.is_powered, needs_stop=needs_stop)

    def report(self) -> None:
        """Report the axis if any of it has changed."""
        own = self.set.own_at(self._clock.now_ns())
        self.answers.report(self.status, self.errors.value, own, is_moving=self.set.is_own_moving)
