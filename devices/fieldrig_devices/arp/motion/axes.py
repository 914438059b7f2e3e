"""The two axes of the card, with an interface for its control loop and one for the program's instructions.

Source: manual 3.2, 4.2.1, 4.6, 5.9; digest chapters 6.1, 7, 8.2, 12 and 13.  Each loop processes axis 2, the master of
PST, first, so that axis 1 follows its present position and not the previous one.  Instructions act from the last
control loop on.  Moves of an axis that may not move (encoder only, PID, not under control) are skipped without an
error.
"""

import logging
from collections.abc import Sequence
from typing import Final

from fieldrig.clock import MS, S
from fieldrig_devices.arp.card_errors import PARAMETERS, CardErrors
from fieldrig_devices.arp.fixed import LIMIT, SCALE
from fieldrig_devices.arp.motion.axis import Axis
from fieldrig_devices.arp.motion.cam_table import CamTable, Demand, TableError, read_points
from fieldrig_devices.arp.motion.electronic_cam import ElectronicCam
from fieldrig_devices.arp.motion.reference_generators import Move, Run
from fieldrig_devices.arp.motion.setup import Setup
from fieldrig_devices.arp.parameters import GENERAL, Kind, Par, Parameters
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.motion import profile
from fieldrig_devices.motion.profile import Limits

log = logging.getLogger(__name__)

SLAVE: Final = 1
MASTER: Final = 2


class Axes:
    def __init__(
        self, parameters: Parameters, flags: list[int], variables: list[int], errors: CardErrors, readings: Readings
    ) -> None:
        self._parameters, self._variables, self._errors, self._readings = parameters, variables, errors, readings
        self._tables = {axis: list(parameters.ram[axis]) for axis in (SLAVE, MASTER)}
        self._version = parameters.version
        self._axes = {axis: Axis(axis, Setup.of(table), flags, errors) for axis, table in self._tables.items()}
        self._slave, self._master = self._axes[SLAVE], self._axes[MASTER]
        self._now_ns: int | None = None

    # ---- the card's side

    def start(self) -> None:
        """Start after a power-on or reset has loaded parameters: control off, VEL/ACC/DEC at 100 %, flags cleared."""
        self._refresh()
        for axis in self._axes.values():
            axis.start()

    def engage(self) -> None:
        """Engage when Enable is high and the card runs: axes of kind 1 and 2 come under control in place.

        F260 is set once they have arrived there.
        """
        self._refresh()
        for axis in self._axes.values():
            axis.engage()

    def release(self) -> None:
        """Switch control off (Enable low, Ctrl-F2, blocking error): output 0; reading continues."""
        for axis in self._axes.values():
            axis.release()

    def control(self, now_ns: int, counts: Sequence[int | None], latches: Sequence[int]) -> None:
        """Run one loop.  `counts[1]` and `counts[2]` are encoder counters (None before the first signal, which reads
        0).

        `latches` are the levels of the latch inputs, by axis.
        """
        self._refresh()
        seconds = self._seconds_to(now_ns)
        slave, master = self._slave, self._master
        master.control(now_ns, seconds, counts[MASTER], latches[MASTER])
        slave.control(now_ns, seconds, counts[SLAVE], latches[SLAVE])
        master.jump = slave.jump = 0.0

    def _seconds_to(self, now_ns: int) -> float:
        last_ns, self._now_ns = self._now_ns, now_ns
        if last_ns is None or now_ns <= last_ns:
            return self._parameters.ram[GENERAL][Par.CONTROL_PERIOD_MS] / SCALE * MS / S
        return (now_ns - last_ns) / S

    def _refresh(self) -> None:
        """Apply changed parameters; a program may change one and use it in the next line."""
        if self._parameters.version == self._version:
            return
        self._version = self._parameters.version
        for axis, table in self._tables.items():
            ram = self._parameters.ram[axis]
            if table != ram:
                table[:] = ram
                self._axes[axis].configure(Setup.of(ram))

    def volts(self, axis: int) -> float | None:
        """Voltage from the position loop to the drive, or None if the axis does not own its output (kind 0, 1, 3)."""
        self._refresh()
        known = self._axes[axis]
        return known.volts if known.setup.kind is Kind.CONTROLLED else None

    def tracking_error(self, axis: int) -> int:
        return _raw(self._axes[axis].error)

    def diagnostic(self, axis: int, code: int) -> float:
        """CurveValue for one of the codes 1 to 9 of @Par[10]; 0 for any other code."""
        known = self._axes[axis]
        match code:
            case 1:
                return float(known.counter.counts)
            case 2:
                return known.reading
            case 3:
                return known.measured_speed
            case 4:
                return known.reference
            case 5:
                return known.speed
            case 6:
                return known.acceleration
            case 7:
                return known.volts
            case 8:
                return known.error
            case 9:
                return float(known.counter.delta)
        return 0.0

    # ---- the program's side: names and arguments as in runtime/card.py

    def position(self, axis: int) -> int:
        return _raw(self._axes[axis].reference)

    def preset_position(self, axis: int, raw: int) -> None:
        self._refresh()
        self._axes[axis].preset(raw / SCALE)

    def speed(self, axis: int) -> int:
        return _raw(self._axes[axis].measured_speed)

    def latched_rising(self, axis: int) -> int:
        return _raw(self._axes[axis].latch.rising)

    def latched_falling(self, axis: int) -> int:
        return _raw(self._axes[axis].latch.falling)

    def limit_speed(self, axis: int, percent: int) -> None:
        self._axes[axis].overrides.speed = percent / SCALE

    def limit_acceleration(self, axis: int, percent: int) -> None:
        self._axes[axis].overrides.acceleration = percent / SCALE

    def limit_deceleration(self, axis: int, percent: int) -> None:
        self._axes[axis].overrides.deceleration = percent / SCALE

    def home(self, axis: int) -> None:
        """Do nothing: HOME has no effect in firmware 3.00 (manual 5.9.2.1)."""

    def move_to(self, axis: int, target: int) -> None:
        if (moved := self._movable(axis)) is not None:
            self._move(moved, target / SCALE)

    def move_by(self, axis: int, distance: int) -> None:
        if (moved := self._movable(axis)) is not None:
            self._move(moved, moved.reference + distance / SCALE)

    def move_at(self, axis: int, percent: int) -> None:
        """Accelerate to a percentage of @ParX[7], limited by VEL."""
        if (moved := self._movable(axis)) is not None:
            limits = moved.overrides.of(moved.setup)
            wanted = moved.setup.speed * min(percent / SCALE, moved.overrides.speed) / 100
            moved.begin(Run(moved, profile.change_speed(moved.speed, wanted, limits)))

    def stop_axis(self, axis: int) -> None:
        """Brake to a stop.  An axis at rest is not affected."""
        moved = self._movable(axis)
        if moved is not None and moved.generator is not None:
            braking = profile.brake(moved.speed, moved.overrides.of(moved.setup))
            moved.begin(Move(moved, braking, moved.reference + braking.distance, obeys_stop_flag=False))

    def follow_table(self, master: int, slave: int, first: int) -> None:
        """Execute PST.  E13, or a master outside the table (without an error), leaves everything unchanged."""
        self._refresh()
        if (master, slave) != (MASTER, SLAVE):
            self._refuse("master and slave must be 2 and 1")
            return
        try:
            table = self._table(first)
        except TableError as cause:
            self._refuse(str(cause))
            return
        if (follower := self._movable(SLAVE)) is None:
            return
        cam = ElectronicCam(follower, self._master, table, self._readings.zero_offset_step == "ignore")
        if cam.is_inside:
            _, acceleration, deceleration = follower.overrides.of(follower.setup)[:3]
            cam.enter(follower, Limits(follower.setup.entry_speed, acceleration, deceleration))

    def _movable(self, axis: int) -> Axis | None:
        """The axis, or None if it is not under control; the instruction is then not executed (manual 5.9.3.1)."""
        self._refresh()
        known = self._axes[axis]
        return known if known.is_controlled else None

    def _move(self, axis: Axis, end: float) -> None:
        trajectory = profile.move(end - axis.reference, axis.speed, axis.overrides.of(axis.setup))
        axis.begin(Move(axis, trajectory, end))

    def _table(self, first: int) -> CamTable:
        setup = self._slave.setup
        if setup.master_speed <= 0:
            raise TableError("@ParX[24] of the slave must be greater than 0")
        speed, acceleration, _ = self._slave.overrides.of_electronic_cam(setup)[:3]
        demand = Demand(setup.master_speed, speed, acceleration)
        points = read_points(self._variables, first)
        return CamTable(points, self._master.setup.span, setup.span, demand, self._readings.pst_join)

    def _refuse(self, why: str) -> None:
        log.debug("PST: %s", why)
        self._errors.fail(PARAMETERS, SLAVE)


def _raw(value: float) -> int:
    """Convert to the raw integer that programs see."""
    return min(max(round(value * SCALE), -LIMIT), LIMIT)
