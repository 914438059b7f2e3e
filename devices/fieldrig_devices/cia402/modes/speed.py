"""The base of modes that move at a speed: changes of speed by ramps, and stops at limit switches and software limits.

Set values are positions, so that the axis holds its position after a stop.
"""

from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.mode import Mode
from fieldrig_devices.cia402.options import Ramp
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.motion.smooth import change_speed


class SpeedMode(Mode):
    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._is_active = False
        self._is_ending = False
        """True while the axis stops at a software limit."""
        self._wanted = 0.0
        self._is_stopped = False
        """True if a limit switch has stopped the axis."""
        self._asked = 0.0
        """The requested speed before limits apply, in increments per second."""
        self._largest = 0.0
        """The largest speed that the limits allowed when the axis last changed to its speed."""

    def limits(self) -> Limits:
        """The ramps of the mode, with the highest speed."""
        raise NotImplementedError

    def begin(self) -> None:
        self._is_active = True
        self.run()

    def end(self) -> None:
        self._is_active = False

    def run(self) -> None:
        """Change to the requested speed, as far as the limits allow."""
        context = self.context
        self._is_ending = self._is_stopped = False
        self._largest = context.largest_speed
        limits = self.limits()
        context.travel.is_limited = abs(self._asked) > limits.speed
        self._wanted = min(max(self._asked, -limits.speed), limits.speed)
        motion = context.motion
        motion.start(change_speed(motion.speed, self._wanted, limits, motion.acceleration))

    def go_on(self) -> None:
        super().go_on()
        self.run()

    def step(self) -> None:
        context = self.context
        travel = context.travel
        if context.largest_speed != self._largest and not (self.is_halted or self._is_ending or self._is_stopped):
            self.run()  # 607Fh or 6080h has been written
        is_limited = context.motor.inputs or travel.held or travel.range is not None or self._is_stopped
        if is_limited and not self.is_halted:
            self._watch_switches()
        context.motion.step(context.cycle_s)

    def _watch_switches(self) -> None:
        context = self.context
        if not context.travel.bars(context.motion.speed or self._wanted):
            if self._is_stopped:
                self.run()
            if context.travel.range is not None and not self._is_ending:
                self._watch_limits()
        elif not self._is_stopped:
            self._is_stopped = True
            self.brake(Ramp.QUICK_STOP)

    def _watch_limits(self) -> None:
        """Start the stop at a software limit in time."""
        context, motion = self.context, self.context.motion
        way = context.travel.stop_ahead(
            motion.position, motion.speed, self._wanted, self.limits(), context.cycle_s, motion.acceleration
        )
        if way is not None:
            self._is_ending = True
            motion.start(way)
