"""The power drive state machine: the transitions that control words cause, and the actions of the drive.

Source: CiA 402-2 / IEC 61800-7-201, chapter 'power drive system state machine' (tables in `states` and `options`).
Our choices where the documents leave room: a state is shown when it is reached, so 'operation enabled' waits for the
brake, and the axis stays in 'operation enabled' during the ramp of transition 5 or 8.  A command remains in force until
the next one, so after a power loss the last control word takes effect again.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.cia402.behaviour import BASELINE, Behaviour, ModeZero
from fieldrig_devices.cia402.drive import Drive
from fieldrig_devices.cia402.fault_resets import FaultResets
from fieldrig_devices.cia402.options import (
    DISABLE_OPTIONS,
    FAULT_OPTIONS,
    QUICK_STOP_OPTIONS,
    SHUTDOWN_OPTIONS,
    Ramp,
)
from fieldrig_devices.drive_profile.states import ENDS, TRANSITIONS, Command, State, command_of

_NOTHING: Final[tuple[Ramp | None, bool]] = None, False


class StateMachine:
    def __init__(self, drive: Drive, behaviour: Behaviour = BASELINE, now_ns: Callable[[], int] = lambda: 0) -> None:
        self._drive, self._behaviour = drive, behaviour
        self._resets = FaultResets(behaviour, now_ns)
        self.has_supply: Callable[[], bool] = lambda: True
        """Returns False as long as the drive has to stay in 'switch on disabled'."""
        self.has_mode: Callable[[], bool] = lambda: True
        """Returns False until a mode of operation has been chosen."""
        self.state = State.NOT_READY_TO_SWITCH_ON
        self.transition = 0
        """Number of the last transition."""
        self.control_word = 0
        self._command: Command | None = None
        self._is_lowered = False
        """True if 'enable operation' counted as 'switch on' only; the same word again then enables."""
        self._after_ramp = 0
        """The transition that follows when the present ramp ends, or 0 if there is none."""
        self._is_enabling = False
        self._wanted: int | None = None
        """The transition that the command requests in this state, or None."""

    def start(self) -> None:
        """Take transition 0, as after power-on."""
        self.control_word, self._command = 0, None
        self._after_ramp, self._is_enabling = 0, False
        self._go(0)

    def control(self, word: int) -> None:
        """Take over a received control word."""
        before, self.control_word = self.control_word, word
        self._is_lowered = False
        self._order(command_of(word))
        if self.state is State.FAULT and self._resets.are_enough(word, before):
            self._drive.reset_fault(self._on_reset)
        self._obey()

    @property
    def has_power(self) -> bool:
        """True if the drive function is enabled or being enabled."""
        return self._is_enabling or self.state in (State.OPERATION_ENABLED, State.QUICK_STOP_ACTIVE)

    @property
    def is_settled(self) -> bool:
        """True if the present command has had its whole effect, so that the same one again changes nothing."""
        is_pending = self._wanted is not None or self._after_ramp != 0 or self._is_enabling or self._is_lowered
        return self._command is not None and not is_pending

    def act(self, command: Command) -> None:
        """Carry out a command for a reason within the drive, and drop the present command."""
        self.forget()
        number = TRANSITIONS.get((self.state, command))
        if number is not None:
            self._begin(number)

    def forget(self) -> None:
        """Drop the present command."""
        self._order(None)

    def step(self) -> None:
        """React to the state of the drive, once per cycle."""
        state, drive = self.state, self._drive
        if state is State.NOT_READY_TO_SWITCH_ON:
            if drive.is_there:
                self._go(1)
            return
        if drive.errors and state not in (State.FAULT, State.FAULT_REACTION_ACTIVE):
            self._fail()
        elif state is State.FAULT_REACTION_ACTIVE:
            self._react()
        elif state in (State.OPERATION_ENABLED, State.QUICK_STOP_ACTIVE) and not drive.is_following:
            self._disable(9 if state is State.OPERATION_ENABLED else 12)
        elif state is State.SWITCHED_ON and not drive.is_ready:
            self._disable(10)
        elif state is State.READY_TO_SWITCH_ON and not self.has_supply():
            self._disable(7)
        elif state is State.FAULT and self._resets.are_enough(self.control_word, self.control_word):
            drive.reset_fault(self._on_reset)
        elif self._after_ramp and drive.is_at_rest:
            self._disable(self._after_ramp)
        self._obey()

    # ---- commands

    def _obey(self) -> None:
        if self._is_enabling and self._command is not Command.ENABLE_OPERATION:
            self._is_enabling = False
            self._drive.disable()
        if self._command is None:
            return
        if self._wanted is not None:
            self._begin(self._wanted)
        elif self._after_ramp in (5, 8) and self._command is Command.ENABLE_OPERATION:
            self._after_ramp = 0  # the ramp is cancelled
            self._drive.go_on()

    def _begin(self, number: int) -> None:
        drive, options = self._drive, self._drive.options
        match number:
            case 2 if not self.has_supply():
                pass
            case 2 | 6:
                self._go(number)
            case 3 if drive.is_ready:
                self._go(3)
                self._obey()
            case 4 if self._behaviour.mode_zero is not ModeZero.NOT_ENABLED or self.has_mode():
                self._enable()
            case 5:
                self._brake(5, DISABLE_OPTIONS.get(options.disable))
            case 7 | 9 | 10 | 12:
                self._disable(number)
            case 8:
                self._brake(8, SHUTDOWN_OPTIONS.get(options.shutdown))
            case 11:
                self._quick_stop()
            case 16 if self._behaviour.quick_stop_resumes or QUICK_STOP_OPTIONS.get(options.quick_stop, _NOTHING)[1]:
                self._after_ramp = 0
                self._go(16)
                drive.go_on()

    def _enable(self) -> None:
        if not self._is_enabling:
            self._is_enabling = True
            self._drive.enable()
        if self._drive.is_following:
            self._is_enabling = False
            self._go(4)
            self._drive.go_on()

    def _brake(self, number: int, ramp: Ramp | None) -> None:
        if ramp is None:
            self._disable(number)
        elif self._after_ramp != number:
            self._after_ramp = number
            self._drive.brake(ramp)

    def _quick_stop(self) -> None:
        ramp, stays = QUICK_STOP_OPTIONS.get(self._drive.options.quick_stop, _NOTHING)
        self._go(11)
        if ramp is None:
            self._disable(12)
            return
        self._after_ramp = 0 if stays else 12
        self._drive.brake(ramp)

    def _disable(self, number: int) -> None:
        self._after_ramp, self._is_enabling = 0, False
        self._drive.disable()
        self._go(number)

    # ---- faults

    def _fail(self) -> None:
        was_enabled = self.state in (State.OPERATION_ENABLED, State.QUICK_STOP_ACTIVE)
        self._after_ramp = 0
        self._resets.begin()
        if self._is_enabling:
            self._is_enabling = False
            self._drive.disable()
        self._go(13)
        ramp = FAULT_OPTIONS.get(self._drive.options.fault)
        if was_enabled and self._drive.is_following and ramp is not None:
            self._after_ramp = 14
            self._drive.brake(ramp)
        self._react()

    def _react(self) -> None:
        drive = self._drive
        if drive.is_following and self._after_ramp and not drive.is_at_rest:
            return
        if not drive.is_following and drive.is_moving_by_itself:
            return  # the drive reacts to its own faults on its own
        self._disable(14)

    def _on_reset(self) -> None:
        if self.state is State.FAULT and not self._drive.errors:
            self._go(15)

    def _go(self, number: int) -> None:
        self.transition, self.state = number, ENDS[number]
        self._order(self._command)

    def _order(self, command: Command | None) -> None:
        is_passing = command is Command.ENABLE_OPERATION and self.state is State.READY_TO_SWITCH_ON
        if is_passing and not self._behaviour.passes_switched_on:
            command, self._is_lowered = Command.SWITCH_ON, True
        self._command = command
        self._wanted = None if command is None else TRANSITIONS.get((self.state, command))
