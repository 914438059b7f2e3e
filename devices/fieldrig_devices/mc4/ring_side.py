"""The drive as the ring sees it: control and status word, cyclic values, parameters, commands.

Source: IEC 61491 by its public facts (S-0-0134, S-0-0135, operation modes, diagnostics of class 1 to 3).  `on_cycle` is
called once per cycle: it advances the axis by the cycle that has passed, under the command values of the last MDT, and
takes those of this one.  While nothing else changes, that is all, and it takes a few microseconds.  A cycle is shorter
still in the cases of `STEADY`, `FOLLOWING` and `REPEAT`.

ControllerEnable is drive on (bit 15).  If only drive enable (bit 14) is reset, the torque is switched off at once; if
both are, the drive ramps down (manual 10.2).  Halt (bit 13) brings the drive to a controlled stop.
"""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import US, Clock
from fieldrig.link import Link
from fieldrig.shortcuts import Shortcut
from fieldrig_bus.ring.sercos.message import RingMessage
from fieldrig_devices.drives.fold import FollowingCycle, PublishedMotion
from fieldrig_devices.drives.loops import INCREMENTS, INNER_NS
from fieldrig_devices.mc4 import idns
from fieldrig_devices.mc4.diagnosis import Code
from fieldrig_devices.mc4.enable import Task
from fieldrig_devices.mc4.feedback import Feedback
from fieldrig_devices.mc4.machine import Machine
from fieldrig_devices.mc4.probes import Probes
from fieldrig_devices.mc4.values import SPEED_UNIT, Number, live_numbers, position_at
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos import words
from fieldrig_devices.sercos.command import Command
from fieldrig_devices.sercos.datum import IdnTable
from fieldrig_devices.sercos.slave import SercosSlave

FOLLOWS: Final = 0x0008
"""Status word: the drive follows its command values."""
CONTROL_BITS: Final = words.APPLICATION_MASK
STEADY: Final = Shortcut("mc4.steady", "a drive whose enables do not change does not evaluate them in each cycle")
FOLLOWING: Final = Shortcut("mc4.following", "a folded cycle also takes the next set position and packs the feedback")
REPEAT: Final = Shortcut("mc4.repeat", "an axis at rest with the same set value repeats its AT")


class RingSide:
    """The drive's application behind the ring protocol (`sercos.slave.Application`)."""

    __slots__ = (
        "_clock", "_command_at", "_control", "_cycle_ns", "_feedback", "_following", "_machine", "_may_be_steady",
        "_may_follow", "_may_repeat", "_most_error", "_numbers", "_slack_ns", "_states_seen", "_status",
        "_steady_control", "_still", "_still_since", "_still_value", "_table", "_until_ns", "_value", "_warnings",
        "_warnings_seen", "is_published", "on_moved", "probes", "published", "slave",
    )  # fmt: skip

    def __init__(self, clock: Clock, ring: Link[RingMessage], address: int, table: IdnTable, machine: Machine) -> None:
        self._clock, self._table, self._machine = clock, table, machine
        self._control = 0
        self._status = 0
        self._steady_control = -1
        """Control bits under which only the axis has to advance; -1 if everything has to be evaluated."""
        self._until_ns = 0
        self._cycle_ns = self._slack_ns = 0
        self._command_at = 0
        """Position of the active command value among the values of the MDT; 0 if none is active."""
        self._value: Callable[[int], None] = _no_value
        self._following: FollowingCycle | None = None
        """The folded cycle, while it applies."""
        self._most_error = 0.0
        self._warnings = self._warnings_seen = self._states_seen = 0
        self._numbers = live_numbers(machine)
        self._numbers |= {134: lambda: self._control, 135: lambda: self._status}
        for idn, number in self._numbers.items():
            self._show(idn, number)
        self.on_moved: Callable[[], None] | None = None
        """Called after each cycle in which only the axis advanced."""
        self.is_published = False
        """True if `on_moved` publishes only the motion of the load, so that it need not be called while that holds."""
        self.published: PublishedMotion | None = None
        """The motion of the load as last published."""
        self._still: bytes | None = None
        """The feedback of an axis at rest, until the next `look`."""
        self._may_be_steady, self._may_follow = STEADY.is_taken, FOLLOWING.is_taken
        self._may_repeat = REPEAT.is_taken
        self._still_value = self._still_since = 0
        """The command value that left the axis at rest, and its `slow_cycles`, which count up when it moves."""
        self._feedback = Feedback(machine, table, (), self._number_of)
        self.slave = SercosSlave(clock, ring, address, table, self)
        self.slave.command(std.RESET_CLASS_1, self._on_reset)
        self.slave.command(idns.READ_PLATE, self._on_read_plate)
        self.probes = Probes(table, lambda: position_at(machine, clock.now_ns()))
        self.slave.command(std.PROBING_COMMAND, self.probes.begin)
        for idn in (
            std.POSITION_WINDOW,
            std.VELOCITY_LIMIT,
            std.TORQUE_LIMIT,
            std.VELOCITY_LOOP_GAIN,
            std.VELOCITY_LOOP_ACTION_TIME,
            std.KV_FACTOR,
            std.LOAD_LIMIT,
            std.STANDSTILL_WINDOW,
            std.MONITORING_WINDOW,
            std.VELOCITY_FEED_FORWARD,
            std.ACCELERATION_FEED_FORWARD,
        ):
            table[idn].watchers.append(self._on_parameter)
        for idn in (206, 207, idns.STOP_TIME_LIMIT, idns.COAST_OPTION):
            table[idn].watchers.append(self._on_time)
        for idn in (std.CLASS_2_MASK, std.CLASS_3_MASK):
            table[idn].watchers.append(self.refresh)
        table[idns.LANGUAGE].watchers.append(self._on_language)
        table[std.CLASS_2_DIAGNOSTIC].reader, table[std.CLASS_3_DIAGNOSTIC].reader = (
            self._read_warnings,
            self._read_states,
        )
        table[std.DIAGNOSTIC_MESSAGE].reader = lambda: table[std.DIAGNOSTIC_MESSAGE].encoded(self.message)
        table[std.CP3_IDNS].set((std.PRIMARY_MODE,))  # what `check` looks at
        table[std.MDT_IDNS].reader = lambda: table[std.MDT_IDNS].encoded(sorted(idns.MODE_COMMANDS.values()))

    # ---- cycles

    def on_cycle(self, values: tuple[int, ...]) -> tuple[int, bytes]:
        control = values[0]
        now_ns, machine = self._clock.now_ns(), self._machine
        if now_ns >= self._until_ns:
            self._look_at_slow_things()
        at_ns = machine.at_ns + self._cycle_ns
        lead_ns = now_ns - at_ns
        is_late = lead_ns and not -self._slack_ns < lead_ns < self._slack_ns
        if is_late or control & CONTROL_BITS != self._steady_control:
            return self._look(values, lead_ns)
        machine.at_ns = at_ns
        axis, value = machine.axis, values[self._command_at]
        if axis.is_at_rest:
            is_same = value == self._still_value and axis.slow_cycles == self._still_since
            if is_same and self._still is not None:
                axis.cycle()
                return self._status, self._still
        elif self._following is not None:
            moved = self._following(axis, value, self._most_error, now_ns, self.published)
            if moved is not None:
                if not self.is_published and self.on_moved is not None:
                    self.on_moved()
                return self._status, moved + self._feedback.standing
        axis.cycle()
        self._value(value)
        if self.on_moved is not None:
            self.on_moved()
        if not -self._most_error < axis.e < self._most_error:
            self._check_following()
        feedback = self._feedback.encode()
        is_still = self._may_repeat and axis.is_at_rest and self._feedback.is_of_the_axis
        self._still, self._still_value, self._still_since = feedback if is_still else None, value, axis.slow_cycles
        return self._status, feedback

    def _look(self, values: tuple[int, ...], lead_ns: int) -> tuple[int, bytes]:
        machine, control = self._machine, values[0]
        if -self._slack_ns < lead_ns < self._slack_ns:
            machine.at_ns += self._cycle_ns
            machine.axis.cycle()
        else:
            machine.catch_up()
        if (control ^ self._control) & CONTROL_BITS:
            self._on_control(control)
        machine.look()
        self._value(values[self._command_at])
        self._check_following()
        return self._status, self._feedback.encode()

    def on_missed_cycle(self, values: tuple[int, ...]) -> tuple[int, bytes]:
        """Continue the set position at its last speed, so that the next command value continues it."""
        machine = self._machine
        self._look(values, self._clock.now_ns() - machine.at_ns - self._cycle_ns)
        if machine.follows and machine.operation_mode & 7 == 3:
            machine.axis.follow(machine.axis.set_increments + machine.axis.moved)
        return self._status, self._feedback.encode()

    def feedback(self) -> bytes:
        """Return the values at the present instant, before the ring's cycle advances the axis."""
        self._machine.catch_up()
        return self._feedback.encode()

    def _look_at_slow_things(self) -> bool:
        """Evaluate temperatures and so on; True if nothing else has changed."""
        machine, status = self._machine, self._status
        has_changed = machine.look_at_slow_things()
        self._until_ns = machine.energy.due_ns
        if has_changed:
            self._steady_control = -1
        elif machine.energy.thermal.warnings != self._warnings or self._table[std.CLASS_3_MASK].number:
            self._status = self._status_word()
        return not has_changed and self._status == status

    def _on_control(self, control: int) -> None:
        before, self._control = self._control, control
        machine = self._machine
        machine.controller = bool(control & words.DRIVE_ON)
        machine.runs = bool(control & words.RUN)
        machine.operation_mode = self._table[32 + (control >> 8 & 3)].number
        if (before ^ control) & words.MODE_MASK:
            machine.rearrange()
        if machine.controller and not control & words.ENABLE:
            machine.controller = False
            machine.chain.take_torque(self._clock.now_ns())

    def _check_following(self) -> None:
        machine = self._machine
        is_position = machine.operation_mode & 7 == 3
        if (
            machine.follows
            and is_position
            and abs(machine.axis.e) * INCREMENTS > self._table[std.MONITORING_WINDOW].number
        ):
            machine.fail(Code.FOLLOWING_ERROR)

    def refresh(self) -> None:
        """Derive the work of a cycle and the status word from the machine, which may have changed."""
        machine = self._machine
        axis, task = machine.axis, machine.chain.task
        mode = machine.operation_mode & 7
        self._command_at = self.slave.places.get(idns.MODE_COMMANDS.get(mode, 0), 0)
        self._value, self._following = _no_value, None
        if task is Task.FOLLOW and machine.runs and self._command_at:
            if mode == 3:
                self._value = axis.follow
                if self._may_follow and (self.published is not None or not self.is_published):
                    self._following = self._feedback.following(axis, is_published=self.is_published)
            elif mode == 2:
                self._value = lambda speed: axis.set_value(speed * SPEED_UNIT)
            elif machine.motor is not None:
                unit = machine.motor.standstill_torque_nm / 1000
                self._value = lambda torque: axis.set_value(torque * unit)
        self._most_error = (
            self._table[std.MONITORING_WINDOW].number / INCREMENTS if machine.follows and mode == 3 else 1e99
        )
        is_steady = self._may_be_steady and machine.is_settled and machine.is_cyclic
        self._steady_control = self._control & CONTROL_BITS if is_steady else -1
        self._until_ns = machine.energy.due_ns
        self._status = self._status_word()
        self._feedback.refresh()
        self._still = None

    # ---- status

    def status(self) -> int:
        return self._status

    def _status_word(self) -> int:
        machine = self._machine
        has_error = machine.diagnosis.has_error
        if machine.chain.has_torque:
            word = words.IN_OPERATION
        elif machine.can_start:
            word = words.POWERED
        else:
            word = words.READY_FOR_POWER if machine.motor is not None else words.NOT_READY
        if has_error:
            word |= words.CLASS_1_ERROR
        if machine.follows:
            word |= FOLLOWS
        self._warnings = machine.energy.thermal.warnings
        if (self._warnings ^ self._warnings_seen) & self._table[std.CLASS_2_MASK].number:
            word |= words.CLASS_2_CHANGED
        mask = self._table[std.CLASS_3_MASK].number
        if mask and (self.states ^ self._states_seen) & mask:
            word |= words.CLASS_3_CHANGED
        return word | self._control & words.MODE_MASK

    @property
    def states(self) -> int:
        """S-0-0013: bit 0 set speed reached, 1 standstill, 4 torque limit reached, 6 in position."""
        machine = self._machine
        axis = machine.axis
        speed = abs(axis.v)
        window = self._table[std.STANDSTILL_WINDOW].number * SPEED_UNIT
        is_in_position = abs(axis.e) * INCREMENTS <= self._table[std.POSITION_WINDOW].number
        at_limit = abs(axis.t) >= 0.999 * axis.limits.torque
        return (abs(axis.v - axis.set_speed) <= window) | (speed <= window) << 1 | at_limit << 4 | is_in_position << 6

    @property
    def message(self) -> str:
        """S-0-0095, the diagnostic message."""
        diagnosis = self._machine.diagnosis
        if diagnosis.code:
            return f"{int(diagnosis.code)} {diagnosis.text}"
        return self._machine.chain.stage.name.lower().replace("_", " ")

    def _read_warnings(self) -> bytes:
        self._warnings_seen = self._machine.energy.thermal.warnings
        self._status = self._status_word()
        return self._table[std.CLASS_2_DIAGNOSTIC].encoded(self._warnings_seen)

    def _read_states(self) -> bytes:
        self._states_seen = self.states
        self._status = self._status_word()
        return self._table[std.CLASS_3_DIAGNOSTIC].encoded(self._states_seen)

    def _show(self, idn: int, number: Number) -> None:
        datum = self._table[idn]
        datum.reader = lambda: datum.encoded(number())

    # ---- phases

    def on_phase(self, phase: int) -> None:
        machine = self._machine
        machine.catch_up()
        machine.is_cyclic = phase == 4
        if phase == 3:
            self._lay_out()
        elif phase == 4:
            machine.at_ns = self._clock.now_ns() - self._cycle_ns
        else:
            self._steady_control = -1
        if phase < 4:
            self._on_control(0)
        machine.look()

    def _lay_out(self) -> None:
        table, machine = self._table, self._machine
        self._cycle_ns = table[std.SERCOS_CYCLE_TIME].number * US
        self._slack_ns = self._cycle_ns // 2
        machine.cycle_steps = self._cycle_ns // INNER_NS
        machine.rearrange()
        self._feedback = Feedback(machine, table, self.slave.telegrams.at, self._number_of)

    def _number_of(self, idn: int) -> Number:
        datum = self._table[idn]
        return self._numbers.get(idn) or (lambda: datum.number)

    def on_ring_failure(self) -> None:
        self._machine.fail(Code.RING)

    def check(self, phase: int) -> list[int]:
        """Refuse CP4 unless the primary mode is supported and its command value is in the MDT, if that has any."""
        mode = self._table[std.PRIMARY_MODE].number
        if phase == 3:
            return []
        mdt = self.slave.telegrams.mdt
        is_given = not mdt or idns.MODE_COMMANDS.get(mode & 7) in mdt
        return [] if mode in idns.MODES and is_given else [32]

    # ---- parameters and commands

    def _on_parameter(self) -> None:
        self._machine.rearrange()
        self._machine.look()

    def _on_time(self) -> None:
        table, times = self._table, self._machine.chain.times
        times.brake_disconnection_ns = table[std.DRIVE_ON_DELAY].number * 1000 * US
        times.brake_coupling_ns = table[std.DRIVE_OFF_DELAY].number * 1000 * US
        times.stop_limit_ns = table[idns.STOP_TIME_LIMIT].number * 1000 * US
        option = table[idns.COAST_OPTION].number
        times.enable_coast, times.error_coast, times.brake_coast = bool(option & 1), bool(option & 2), bool(option & 4)

    def _on_language(self) -> None:
        self._machine.diagnosis.language = "en" if self._table[idns.LANGUAGE].number else "de"

    def _on_reset(self, command: Command) -> None:
        """S-0-0099: acknowledge errors, after reading a name plate again that could not be read."""

        def end(_is_read: bool = True) -> None:
            is_good = self._machine.quit()
            if is_good:
                self.slave.clear_failures()
            command.finish(is_good=is_good)

        if self._machine.lacks_plate:
            self._machine.read_plate(end)
        else:
            end()

    def _on_read_plate(self, command: Command) -> None:
        if self._machine.chain.has_torque:
            command.finish(is_good=False)
        else:
            self._machine.read_plate(lambda is_good: command.finish(is_good=is_good))


def _no_value(value: int) -> None:
    """Ignore the command value."""
