"""A PTO channel: its motion states, its commands and its errors (SCU-025, SCU-038 to SCU-062, digest 6 to 8).

The diagram of the states is lost in the manual; they follow the single-axis model of PLCopen.
"""

from typing import Final

from fieldrig.clock import MS
from fieldrig_devices.hmiscu.enumerations import Direction, ErrorId, Parameter
from fieldrig_devices.hmiscu.filtered_input import FilteredInput
from fieldrig_devices.hmiscu.pto.checks import Situation, Wrong, check
from fieldrig_devices.hmiscu.pto.command import Command, Order, Status
from fieldrig_devices.hmiscu.pto.matrix import MATRIX, Next, Outcome, Running
from fieldrig_devices.hmiscu.pto.output import OnSegments, PulseOutput
from fieldrig_devices.hmiscu.pto.piece import Plan
from fieldrig_devices.hmiscu.pto.planner import Ends, Planner, handed_over
from fieldrig_devices.hmiscu.pto.settings import PtoSettings
from fieldrig_devices.hmiscu.pto.status import Diagnosis, MotionState

DEFAULT_MAST_NS: Final = 10 * MS
_SIGN: Final = {Direction.PTO_POSITIVE: 1, Direction.PTO_NEGATIVE: -1}


class PtoChannel:
    """The axis behind the blocks.  Call `advance` at `next_ns`, or any method later: instants never go back."""

    def __init__(
        self,
        settings: PtoSettings,
        on_segments: OnSegments,
        *,
        name: str = "",
        mast_ns: int = DEFAULT_MAST_NS,
        start_ns: int = 0,
    ) -> None:
        """`name` is the wire of the pulse train; `mast_ns` is the default of the hand-over."""
        self.settings = settings
        self.output = PulseOutput(name, on_segments, start_ns)
        self.state = MotionState.STANDSTILL
        self.diagnosis = Diagnosis.NONE
        self.is_drive_ready_ignored = False
        """The pin DIS_AuxInput."""
        self.is_linked = True
        """False while the connection to the firmware of the outputs is broken; change it by `set_linked`."""
        self.executing: set[object] = set()
        """The PTOMoveRelative blocks whose Execute is TRUE."""
        self.reset_problem = ""
        """Why the last reset had no effect; empty if it had one."""
        self.direction_level = False
        self._ready = FilteredInput(settings.aux_filter_ms * MS)
        self._planner = Planner(settings)
        self._hand_over_ns = mast_ns if settings.hand_over_ms is None else settings.hand_over_ms * MS
        self._command: Command | None = None
        """The command that controls the axis."""
        self._holder: Command | None = None
        """The PTOStop that keeps the axis at rest while its Execute is TRUE."""
        self._direction = Direction.PTO_POSITIVE
        self._target_hz = 0
        self._moved_from = 0
        self._is_restarting = False
        self.parameters: dict[int, int] = {}
        self._configure()
        self._ends = self._present_ends()

    def _configure(self) -> None:
        self.parameters = {
            Parameter.PTO_START_FREQUENCY: self.settings.start_frequency_hz,
            Parameter.PTO_STOP_FREQUENCY: self.settings.stop_frequency_hz,
        }

    def _present_ends(self) -> Ends:
        return Ends(self.parameters[Parameter.PTO_START_FREQUENCY], self.parameters[Parameter.PTO_STOP_FREQUENCY])

    # ---- readings

    @property
    def next_ns(self) -> int:
        """The next instant at which something happens by itself; `NEVER_NS` if nothing will."""
        return min(self.output.next_ns, self._ready.next_ns)

    @property
    def is_moving(self) -> bool:
        return self.state in (MotionState.DISCRETE_MOTION, MotionState.CONTINUOUS_MOTION)

    @property
    def is_stopping(self) -> bool:
        return self.state is MotionState.STOPPING or (self.state is MotionState.ERROR_STOP and self.output.is_moving)

    def distance_at(self, now_ns: int) -> int:
        """Return the pulses since the last move began from standstill."""
        return self.output.sent_at(now_ns) - self._moved_from

    def levels_at(self, now_ns: int) -> tuple[bool, bool]:
        """Return the levels of output 0 and output 1 (SCU-012)."""
        levels = self.output.train.level_at(now_ns), self.direction_level
        return levels if self.settings.output_mode == "pulse/direction" else levels[::-1]

    # ---- time and inputs

    def advance(self, now_ns: int) -> None:
        """Carry out everything that is due, each at its own instant."""
        while (due_ns := self.next_ns) <= now_ns:
            self._ready.advance(due_ns)
            self.output.advance(due_ns)
            self._settle(due_ns)
        self._settle(now_ns)

    def put_drive_ready(self, now_ns: int, level: bool) -> None:
        """Take the level of input DI2."""
        self.advance(now_ns)
        self._ready.put(now_ns, level)

    def set_linked(self, now_ns: int, is_linked: bool) -> None:
        """Break or restore the connection to the firmware of the outputs, which stops the axis without it (SCU-065)."""
        self.advance(now_ns)
        self.is_linked = is_linked
        if not is_linked:
            self._trip(now_ns, ErrorId.PTO_COM_ERROR, Diagnosis.NONE)

    def fail(self, now_ns: int) -> None:
        """Take an internal error, or a stop exception of the firmware (SCU-062)."""
        self.advance(now_ns)
        self._trip(now_ns, ErrorId.PTO_AXIS_ERROR, Diagnosis.INTERNAL_ERROR)

    def shutdown(self, now_ns: int) -> None:
        """Stop because the controller leaves RUN, the panel goes offline, or the runtime ends (SCU-018, SCU-099)."""
        self.advance(now_ns)
        if self.output.is_moving:
            self._trip(now_ns, ErrorId.PTO_AXIS_ERROR, Diagnosis.NONE, is_shutdown=True)

    def restart(self, now_ns: int) -> None:
        """Begin again as after a cold or warm start, with the configured parameters, once the axis is at rest.

        The blocks begin again as well, so none of them has Execute.
        """
        self.advance(now_ns)
        if self.output.is_moving and self.state is not MotionState.ERROR_STOP:
            self._trip(now_ns, ErrorId.PTO_AXIS_ERROR, Diagnosis.NONE, is_shutdown=True)
        self._configure()
        self.executing.clear()
        self.reset_problem = ""
        self.is_drive_ready_ignored = False
        self._is_restarting = True
        self._settle(now_ns)

    def reset(self, now_ns: int) -> None:
        """Reset the error, if the axis is at rest, no PTOMoveRelative has Execute, and the cause is gone (SCU-029)."""
        self.advance(now_ns)
        self.reset_problem = self._why_no_reset() if self.state is MotionState.ERROR_STOP else ""
        if self.reset_problem:
            return
        self.diagnosis = Diagnosis.NONE
        if self.state is MotionState.ERROR_STOP:
            self.state = MotionState.STANDSTILL

    def _why_no_reset(self) -> str:
        if not self.is_linked:
            return "the connection to the outputs is broken"
        if self._is_drive_missing():
            return "the drive is not ready"
        if self.executing:
            return "a PTOMoveRelative has Execute"
        return "the axis moves" if self.output.is_moving else ""

    def _is_drive_missing(self) -> bool:
        return self.settings.aux == "drive_ready" and not self._ready.level and not self.is_drive_ready_ignored

    def _settle(self, now_ns: int) -> None:
        """Take the transitions of the states that time or inputs cause."""
        if self._is_drive_missing() and not self.diagnosis & Diagnosis.DRIVE_NOT_READY:
            self._trip(now_ns, ErrorId.PTO_AXIS_ERROR, Diagnosis.DRIVE_NOT_READY)
        if self.output.is_moving:
            if self.output.is_endless and self._command is not None and self._command.status is Status.BUSY:
                self._command.status = Status.REACHED
            return
        if self.state is MotionState.DISCRETE_MOTION:
            self._complete()
            self.state = MotionState.STANDSTILL
        elif self.state is MotionState.STOPPING:
            self._complete()
            self.direction_level = False  # SCU-093
            if self._holder is None or not self._holder.is_held:
                self.state, self._holder = MotionState.STANDSTILL, None
        if self._is_restarting:
            self._is_restarting, self.state, self.diagnosis = False, MotionState.STANDSTILL, Diagnosis.NONE

    def _complete(self) -> None:
        if self._command is not None:
            self._command.end(Status.REACHED)
            self._command = None

    # ---- commands

    def give(self, now_ns: int, order: Order) -> Command:
        """Take a motion command at the rising edge of its Execute."""
        self.advance(now_ns)
        command = Command(order)
        if not self.is_linked:
            command.end(Status.ERROR, ErrorId.PTO_COM_ERROR)
        elif self.state is MotionState.ERROR_STOP or (self.state is MotionState.STOPPING and not self.output.is_moving):
            command.end(Status.ERROR, ErrorId.PTO_AXIS_ERROR)
            self.diagnosis |= Diagnosis.COMMAND_REJECTED
        elif self.state is MotionState.STANDSTILL:
            self._from_standstill(now_ns, command)
        else:
            self._while_running(now_ns, command)
        self._settle(now_ns)
        return command

    def _check(self, order: Order, moving: Direction | None) -> Wrong:
        ends = self._present_ends()
        return check(order, Situation(self.settings, ends.start_hz, ends.stop_hz, moving))

    def _from_standstill(self, now_ns: int, command: Command) -> None:
        order, ends = command.order, self._present_ends()
        wrong = self._check(order, None)
        plan: Plan | None = iter(())
        if not wrong.is_wrong and order.kind is Next.MOVE_RELATIVE:
            plan = self._planner.move_relative(order, ends)
        elif not wrong.is_wrong and order.kind is Next.MOVE_VELOCITY:
            plan = self._planner.from_rest(order, ends)
        if wrong.is_wrong or plan is None:
            command.end(Status.ERROR, ErrorId.PTO_INVALID_PARAMETER)
            self._stop_by_error(now_ns, wrong.bits if plan is not None else Diagnosis.INVALID_FREQUENCY)
            return
        self._ends, self._command = ends, command
        if order.kind is Next.STOP:
            self.state, self._holder = MotionState.STOPPING, command
            return
        is_relative = order.kind is Next.MOVE_RELATIVE
        self.state = MotionState.DISCRETE_MOTION if is_relative else MotionState.CONTINUOUS_MOTION
        command.is_active = True
        self._target_hz = order.velocity
        self._moved_from = self.output.train.sent_at(now_ns)
        if order.direction != Direction.PTO_CURRENT:
            self._direction = Direction(order.direction)
        is_positive = self._direction is Direction.PTO_POSITIVE
        self.direction_level = is_positive == self.settings.positive_level
        self.output.begin(now_ns, plan, _SIGN[self._direction])

    def _running(self) -> Running:
        if self.state is MotionState.DISCRETE_MOTION:
            return Running.MOVE_RELATIVE
        if self.state is MotionState.STOPPING:
            return Running.STOP_DECELERATING
        return Running.VELOCITY_CONSTANT if self.output.is_endless else Running.VELOCITY_RAMPING

    def _while_running(self, now_ns: int, command: Command) -> None:
        outcome = MATRIX[self._running(), command.order.kind]
        wrong = self._check(command.order, self._direction)
        if outcome is Outcome.AXIS_ERROR:
            error = ErrorId.PTO_INVALID_PARAMETER if wrong.is_wrong else ErrorId.PTO_AXIS_ERROR
            self._end_both(Status.ERROR, ErrorId.PTO_AXIS_ERROR, command, error)
            self._stop_by_error(now_ns, Diagnosis.COMMAND_REJECTED | wrong.bits)
        elif outcome is Outcome.COMMAND_ABORTED or wrong.is_wrong:
            self._end_both(Status.ABORTED, ErrorId.NO_ERROR, command, ErrorId.PTO_INVALID_PARAMETER)
            is_rejected = outcome is Outcome.COMMAND_ABORTED
            self._stop_by_error(now_ns, wrong.bits | (Diagnosis.COMMAND_REJECTED if is_rejected else Diagnosis.NONE))
        elif outcome is Outcome.IMMEDIATE_ACCEPT:
            self._accept_stop(now_ns, command)
        else:
            self._accept_velocity(now_ns, command)

    def _end_both(self, status: Status, error: ErrorId, command: Command, its_error: ErrorId) -> None:
        if self._command is not None:
            self._command.end(status, error)
        command.end(Status.ERROR, its_error)

    def _accept_stop(self, now_ns: int, command: Command) -> None:
        is_done = self.state is MotionState.DISCRETE_MOTION and self.settings.stop_reports == "done"
        self._take_over(Status.REACHED if is_done else Status.ABORTED, command)
        self.state, self._holder = MotionState.STOPPING, command
        at = self.output.junction(now_ns)
        plan = self._planner.stop(command.order.deceleration, at.square, self._target_hz, self._ends.stop_hz)
        self.output.replace(at, handed_over(plan, at.square, self._hand_over_ns))

    def _accept_velocity(self, now_ns: int, command: Command) -> None:
        self._take_over(Status.ABORTED, command)
        at = self.output.junction(now_ns)
        plan = self._planner.to_velocity(command.order, self._target_hz)
        self._target_hz = command.order.velocity
        self.output.replace(at, handed_over(plan, at.square, self._hand_over_ns))

    def _take_over(self, status: Status, command: Command) -> None:
        """Let a command take the axis from the present one, which gets a status."""
        if self._command is not None:
            self._command.end(status)
        self._command, self._ends = command, self._present_ends()

    # ---- errors

    def _trip(self, now_ns: int, error: ErrorId, bits: Diagnosis, *, is_shutdown: bool = False) -> None:
        """Take an error that no command causes."""
        if self._command is not None:
            self._command.end(Status.ERROR, error)
        self._stop_by_error(now_ns, bits, is_shutdown=is_shutdown)

    def _stop_by_error(self, now_ns: int, bits: Diagnosis, *, is_shutdown: bool = False) -> None:
        """Go into ErrorStop, with a fast stop if the axis moves and does not make one yet."""
        self.diagnosis |= bits
        is_new = self.state is not MotionState.ERROR_STOP
        self.state, self._command, self._holder = MotionState.ERROR_STOP, None, None
        if self.output.is_moving and (is_new or is_shutdown):
            at = self.output.junction(now_ns)
            self.output.replace(at, self._planner.fast_stop(at.square, self._ends.stop_hz, is_shutdown))
