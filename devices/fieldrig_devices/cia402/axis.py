"""One CiA 402 axis: its state machine, its modes of operation, and what both show in the object dictionary.

Source: CiA 402-2 (objects, modes, status word), CiA 402-3 (axes of a node).  The owner of the motor calls `step` once
per motor cycle, and passes `drive.kind` and `drive.set_value` to the motor while the motor follows.  Commands from the
network take effect immediately, so a status word that is read after a control word already shows its effect.
Bits 8, 14 and 15 of the status word stay 0 by default (`behaviour`).
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from enum import IntEnum
from typing import Final

from fieldrig.clock import Clock
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.service import Reset, Service
from fieldrig_devices.canopen.service import State as NmtState
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.axis_drive import NO_MODE, AxisDrive
from fieldrig_devices.cia402.axis_objects import NOTHING, AxisObjects, Key
from fieldrig_devices.cia402.behaviour import BASELINE, Behaviour, FreeBit, ModeZero
from fieldrig_devices.cia402.bits import free_bits, has_voltage_bit
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.control_cycle import ControlCycle
from fieldrig_devices.cia402.mode_display import ModeDisplayed
from fieldrig_devices.cia402.modes.mode import HALT
from fieldrig_devices.cia402.motor import Motor
from fieldrig_devices.cia402.shown import show
from fieldrig_devices.cia402.si_units import SiUnits
from fieldrig_devices.cia402.state_machine import StateMachine
from fieldrig_devices.cia402.touch_probe import TouchProbes
from fieldrig_devices.drive_profile.states import Command, State

# Bits of the status word in addition to those of the state and of the mode
VOLTAGE_ENABLED: Final = 0x0010
WARNING: Final = 0x0080
REMOTE: Final = 0x0200

COMMUNICATION_LOST: Final = 0x8130
"""Error code in 603Fh."""
_ON: Final = (State.OPERATION_ENABLED, State.QUICK_STOP_ACTIVE)
_FAULTS: Final = (State.FAULT, State.FAULT_REACTION_ACTIVE)


class AbortConnection(IntEnum):
    """Abort connection option codes (6007h); 0 does nothing."""

    FAULT_SIGNAL = 1
    DISABLE_VOLTAGE = 2
    QUICK_STOP = 3


class Cia402Axis(Service):
    """Axis number `axis` of a node, counted from 0."""

    def __init__(
        self,
        clock: Clock,
        dictionary: Dictionary,
        axis: int,
        motor: Motor,
        cycle_ns: int,
        behaviour: Behaviour = BASELINE,
        defaults: Mapping[Key, int] = NOTHING,
    ) -> None:
        """`defaults` are the numbers to use where the dictionary lacks the object, or where its value is 0."""
        self._numbers = AxisObjects(dictionary, axis, defaults)
        self._motor = motor
        self._context = Context(self._numbers, motor, cycle_ns, behaviour)
        self.drive = AxisDrive(self._numbers, motor, self._context)
        self._behaviour = behaviour
        self.machine = StateMachine(self.drive, behaviour, clock.now_ns)
        self.machine.has_mode = lambda: self.drive.shown_mode != NO_MODE
        self._control = ControlCycle(clock, behaviour.control_cycle_ms, self._on_control)
        self._displayed = ModeDisplayed(clock, behaviour, self._show)
        self._waiting_mode = NO_MODE
        """The mode that waits for the end of a halt."""
        self._nmt = NmtState.INITIALISING
        self._remote = REMOTE if behaviour.remote_bit else 0
        self._has_free_bits = {behaviour.bit_14, behaviour.bit_15} != {FreeBit.NONE}
        self._probes = TouchProbes(clock, self._numbers, motor, self._context)
        self._was_lost = False
        self.pace = self._context.pace
        self.on_errors: Callable[[Sequence[int], Collection[int]], None] = lambda new, gone: None
        """Called with the error codes that are new, in their order, and with those that are no longer there."""
        self.on_home: Callable[[float], None] = lambda origin: None
        """Called with each new origin, in increments."""
        self._reported: list[int] = []
        """Present error codes in the order in which they occurred."""
        self._last_error = 0
        """Last error code since power-on (603Fh); a fault reset does not clear it."""
        self._most_torque = objects.FULL_TORQUE
        """Torque limit last passed to the motor; until the first one the motor uses its own."""
        self._context.on_quick_stop = self._stop_quickly
        self._context.on_home = lambda origin: self.on_home(origin)
        self._connect()

    # ---- the node

    def reset(self, scope: Reset) -> None:
        self._was_lost = False
        self._numbers.reload()
        self._context.refresh()
        if self._context.most_torque != self._most_torque:
            self.limit_torque()
        self._set_outputs()
        if scope is Reset.NODE:
            self.restart()
        else:
            self.lose_connection()

    def use_units(self, units: SiUnits, defaults: Mapping[Key, int]) -> None:
        """Take other units of velocities and accelerations, with the numbers for missing objects in them."""
        self._numbers.use_defaults(defaults)
        self._context.si = units
        self._context.refresh()

    def enter(self, state: NmtState) -> None:
        left, self._nmt = self._nmt is NmtState.OPERATIONAL and state is not NmtState.OPERATIONAL, state
        if state is NmtState.STOPPED or (left and self._behaviour.leaving_counts):
            self.lose_connection()

    def on_communication_error(self, is_lost: bool) -> None:
        if is_lost and not self._was_lost:
            self.lose_connection()
        self._was_lost = is_lost

    def use(self, cycle_ns: int, origin: float | None) -> None:
        """Set the cycle time, and the origin if the axis has been homed before; called before a start."""
        self._context.use(cycle_ns, origin)

    def restart(self) -> None:
        """Start as after power-on, or with another motor: disabled."""
        self.drive.disable()
        self._reported, self._last_error = [], 0
        self.pace.wake()
        self.drive.restart()
        self._probes.restart()
        self._control.restart()
        self._displayed.restart()
        self._waiting_mode = NO_MODE
        self.machine.start()
        if self._numbers[objects.MODE] in self.drive.supported:
            self._on_mode(self._numbers[objects.MODE])
        self._show()

    def _stop_quickly(self) -> None:
        self.pace.wake()
        self.machine.act(Command.QUICK_STOP)

    def fail(self, code: int) -> None:
        """Have a fault with this error code."""
        self.drive.fail(code)

    def lose_connection(self) -> None:
        """React as 6007h says.  Only an axis with power has a fault; any other axis drops its present command."""
        self.pace.wake()
        match self._numbers[objects.ABORT_CONNECTION]:
            case AbortConnection.FAULT_SIGNAL if self.machine.has_power:
                self.drive.fail(COMMUNICATION_LOST)
            case AbortConnection.FAULT_SIGNAL:
                self.machine.forget()
            case AbortConnection.DISABLE_VOLTAGE:
                self.machine.act(Command.DISABLE_VOLTAGE)
            case AbortConnection.QUICK_STOP:
                self.machine.act(Command.QUICK_STOP)

    # ---- objects

    def _connect(self) -> None:
        numbers = self._numbers
        numbers.changed = self._context.refresh
        numbers.on_write(objects.CONTROL_WORD, self._control.take if self._control.is_slow else self._on_control)
        numbers.variable(objects.CONTROL_WORD).is_command = True
        numbers.on_write(objects.MODE, self._on_mode)
        for index in (objects.MAX_TORQUE, objects.MAX_CURRENT):
            numbers.on_write(index, lambda _written: self.limit_torque())
        for subindex in (1, 2):
            numbers.on_write(objects.OUTPUTS, lambda _written: self._set_outputs(), subindex)
        self._connect_modes()
        show(numbers, self._context, self._motor, self.drive)
        numbers.read_by(objects.MODE_DISPLAY, lambda: self.mode_display)
        numbers.read_by(objects.ERROR_CODE, lambda: self._last_error)
        numbers.read_by(objects.STATUS_WORD, lambda: self.status_word)

    def _connect_modes(self) -> None:
        """Connect the modes to their objects.  Modes may share an object; each one checks whether it is active."""
        together: dict[tuple[int, int], list[Callable[[int], None]]] = {}
        for mode in self.drive.modes.values():
            for key, act in mode.writers().items():
                together.setdefault(key, []).append(act)
        for (index, subindex), actions in together.items():
            self._numbers.on_write(index, _all(actions), subindex)

    def _on_control(self, word: int) -> None:
        if word == self.machine.control_word and self.machine.is_settled:
            return  # a master that sends a control word in every cycle repeats it, which changes nothing
        self.pace.wake()
        drive, before = self.drive, self.machine.control_word
        self.machine.control(word)
        if drive.shown_mode != NO_MODE:
            drive.mode.control(word, word & ~before if drive.is_moving else 0)
        drive.halt(bool(word & HALT))
        if self._waiting_mode != NO_MODE and not word & HALT:
            self._on_mode(self._waiting_mode)
        self._show()

    def _on_mode(self, number: int) -> None:
        behaviour, self._waiting_mode = self._behaviour, NO_MODE
        if number == NO_MODE and behaviour.mode_zero is not ModeZero.REFUSED:
            return  # CiA 402-2: 'no mode change'
        if number not in self.drive.supported:
            raise Abort(Code.INVALID_VALUE)
        if number == self.drive.shown_mode:
            return
        if not behaviour.changes_mode_in_halt and self.machine.control_word & HALT:
            self._waiting_mode = number
            return
        self.drive.change_mode(number)
        self.drive.mode.control(self.machine.control_word, 0)
        self._show()

    def limit_torque(self) -> None:
        """Pass the limits of 6072h and 6073h to the motor."""
        self._most_torque = self._context.most_torque
        self._motor.limit_torque(self._most_torque)

    def _set_outputs(self) -> None:
        numbers = self._numbers.numbers
        self._motor.set_outputs(numbers[objects.OUTPUTS, 1], numbers[objects.OUTPUTS, 2])

    # ---- once a cycle

    @property
    def is_awake(self) -> bool:
        """True if the next cycle has to be a whole one, although the state of the motor has not changed."""
        return self.pace.is_awake

    def step(self) -> None:
        """Advance by one cycle, with its actual values; afterwards `drive.set_value` belongs to this cycle.

        While the axis is not awake, `drive.advance` has the same effect, and is needed only while a mode moves it.
        """
        state, drive = self.machine.state, self.drive
        if self._probes.is_armed:
            self._probes.step()
        self.machine.step()
        drive.step()
        self.pace.leave_band()
        is_unsettled = drive.has_own_error if drive.is_moving else drive.is_ramp
        is_eventful = is_unsettled or self._probes.is_armed or self.machine.state is not state
        self.pace.is_awake = is_eventful or self.pace.is_always_whole
        self._report()

    def _report(self) -> None:
        errors = self.drive.errors if self.machine.state in _FAULTS else ()
        if not errors and not self._reported:
            return
        new = [code for code in dict.fromkeys(errors) if code not in self._reported]
        gone = [code for code in self._reported if code not in errors]
        if new or gone:
            self._reported = [code for code in self._reported if code in errors] + new
            self._last_error = new[-1] if new else self._last_error
            self.on_errors(new, gone)

    @property
    def error(self) -> int:
        """Code of the last error that occurred of those that are present; 0 if there is none."""
        errors = self.drive.errors
        return next((code for code in reversed(self._reported) if code in errors), errors[-1] if errors else 0)

    @property
    def status_word(self) -> int:
        motor, state = self._motor, self.machine.state
        if state is State.NOT_READY_TO_SWITCH_ON:
            return 0
        behaviour = self._behaviour
        word: int = state.value | self.drive.following_status | self._remote
        if self._has_free_bits:
            word |= free_bits(behaviour, motor, self._context)
        if has_voltage_bit(behaviour, motor, is_enabled=state in _ON):
            word |= VOLTAGE_ENABLED
        if motor.has_warning:
            word |= WARNING
        if state in _ON:
            word |= self.drive.mode_status
        return word

    @property
    def mode_display(self) -> int:
        """The present value of 6061h."""
        return self._displayed.of(self.drive.shown_mode, is_enabled=self.machine.state in _ON)

    def _show(self) -> None:
        """Update the objects that a command may have changed, so that TPDOs of this instant carry them."""
        self._numbers.put(objects.STATUS_WORD, self.status_word)
        self._numbers.put(objects.MODE_DISPLAY, self.mode_display)


def _all(actions: list[Callable[[int], None]]) -> Callable[[int], None]:
    def act(value: int) -> None:
        for action in actions:
            action(value)

    return act
