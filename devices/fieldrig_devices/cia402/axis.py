"""One CiA 402 axis: its state machine, its modes of operation, and what both show in the object dictionary.

Source: CiA 402-2 (objects, modes, status word), CiA 402-3 (axes of a node).  Whoever has the motor calls `step` in each
of its cycles, and gives `kind` and `set_value` to the motor while it follows.  Commands of the network count at once,
so that the status word that is read after a control word is the one that it led to.
Left out: velocity mode (vl, 6042h on), touch probes, limit switches outside of homing (60FDh shows them).
Ours: a following error beyond 6065h and 6066h is a fault, 8611h; bit 8, 14 and 15 of the status word stay 0.
"""

from collections.abc import Callable
from enum import IntEnum
from typing import Final

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.service import Reset, Service
from fieldrig_devices.canopen.service import State as NmtState
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.axis_objects import AxisObjects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.cyclic import CyclicPosition, CyclicVelocity
from fieldrig_devices.cia402.modes.homing import Homing
from fieldrig_devices.cia402.modes.interpolated import InterpolatedPosition
from fieldrig_devices.cia402.modes.mode import BIT_13, HALT, Mode
from fieldrig_devices.cia402.modes.profile_position import ProfilePosition
from fieldrig_devices.cia402.modes.profile_velocity import ProfileVelocity
from fieldrig_devices.cia402.modes.torque import CyclicTorque, ProfileTorque
from fieldrig_devices.cia402.motor import Kind, Motor
from fieldrig_devices.cia402.options import HALT_OPTIONS, Options, Ramp
from fieldrig_devices.cia402.state_machine import StateMachine
from fieldrig_devices.cia402.states import State
from fieldrig_devices.cia402.units import wrapped
from fieldrig_devices.cia402.window import Window
from fieldrig_devices.motion.profile import brake

# Status word, besides the state's bits and the mode's
VOLTAGE_ENABLED: Final = 0x0010
WARNING: Final = 0x0080
REMOTE: Final = 0x0200
INTERNAL_LIMIT: Final = 0x0800

FOLLOWING_ERROR: Final = 0x8611
"""Of 603Fh."""
COMMUNICATION_LOST: Final = 0x8130
NO_MODE: Final = 0
MODES: Final[tuple[type[Mode], ...]] = (
    ProfilePosition, ProfileVelocity, ProfileTorque, Homing, InterpolatedPosition,
    CyclicPosition, CyclicVelocity, CyclicTorque,
)  # fmt: skip
SHOWS_FOLLOWING_ERROR: Final = (ProfilePosition.number, CyclicPosition.number)

_ON: Final = (State.OPERATION_ENABLED, State.QUICK_STOP_ACTIVE)


class AbortConnection(IntEnum):
    """6007h; 0: nothing happens."""

    FAULT_SIGNAL = 1
    DISABLE_VOLTAGE = 2
    QUICK_STOP = 3


class Cia402Axis(Service):
    """Number `axis` of a node, from 0."""

    def __init__(self, dictionary: Dictionary, axis: int, motor: Motor, cycle_ns: int) -> None:
        self._numbers = AxisObjects(dictionary, axis)
        self._motor = motor
        self._context = Context(self._numbers, motor, cycle_ns)
        self.machine = StateMachine(self)
        self._modes = {mode.number: mode for mode in (kind(self._context) for kind in MODES)}
        self._mode: Mode = self._modes[ProfilePosition.number]
        self._shown_mode = NO_MODE
        self._is_moving = False
        """The mode gives the set values, and no ramp does."""
        self._is_ramp = False
        self._is_halted = False
        self._own_error = 0
        self._was_lost = False
        self._following = Window()
        self._is_woken = True
        self._following_error = 0.0
        """What was demanded in the cycle before, minus what is."""
        self.kind = Kind.POSITION
        self.set_value: float = 0
        self.on_error: Callable[[int], None] = lambda code: None
        """Hears of each new error code, and of 0 when a fault was reset."""
        self.on_home: Callable[[float], None] = lambda origin: None
        """Hears of each new origin, in increments."""
        self._reported = 0
        self._context.on_home = lambda origin: self.on_home(origin)
        self._connect()

    # ---- the node

    def reset(self, scope: Reset) -> None:
        self._numbers.reload()
        self._context.refresh()
        if scope is Reset.NODE:
            self.restart()
        else:
            self._lose_connection()

    def enter(self, state: NmtState) -> None:
        if state is NmtState.STOPPED:
            self._lose_connection()

    def on_communication_error(self, is_lost: bool) -> None:
        if is_lost and not self._was_lost:
            self._lose_connection()
        self._was_lost = is_lost

    def use(self, cycle_ns: int, origin: float | None) -> None:
        """Before a start: how long cycles are, and where zero is, if the axis was homed before."""
        self._context.use(cycle_ns, origin)

    def restart(self) -> None:
        """Power-on, or another motor: nothing is enabled."""
        if self.machine.state in _ON:
            self.disable()
        self._own_error = self._reported = 0
        self._is_woken = True
        self._mode.end()
        self._shown_mode = NO_MODE
        self._is_moving = self._is_ramp = False
        self.machine.start()
        if self._numbers[objects.MODE] in self._supported():
            self._on_mode(self._numbers[objects.MODE])
        self._show()

    def _lose_connection(self) -> None:
        """6007h; only an axis under power has something to lose."""
        if self.machine.state not in _ON:
            return
        self._is_woken = True
        match self._numbers[objects.ABORT_CONNECTION]:
            case AbortConnection.FAULT_SIGNAL:
                self._own_error = COMMUNICATION_LOST
            case AbortConnection.DISABLE_VOLTAGE:
                self.machine.disable_voltage()
            case AbortConnection.QUICK_STOP:
                self.machine.quick_stop()

    def _connect(self) -> None:
        numbers, context, motor = self._numbers, self._context, self._motor
        numbers.changed = context.refresh
        numbers.on_write(objects.CONTROL_WORD, self._on_control)
        numbers.on_write(objects.MODE, self._on_mode)
        for subindex in (1, 2):
            numbers.on_write(objects.OUTPUTS, self._on_outputs, subindex)
        self._connect_writers()
        for index, read in (
            (objects.ERROR_CODE, lambda: self.error),
            (objects.STATUS_WORD, lambda: self.status_word),
            (objects.MODE_DISPLAY, lambda: self._shown_mode),
            (objects.POSITION_DEMAND, lambda: wrapped(context.units.position(context.motion.position))),
            (objects.POSITION_INTERNAL, lambda: wrapped(motor.position)),
            (objects.POSITION_ACTUAL, lambda: wrapped(context.units.position(motor.position))),
            (objects.VELOCITY_DEMAND, lambda: context.units.velocity(context.motion.speed)),
            (objects.VELOCITY_ACTUAL, lambda: context.units.velocity(motor.velocity)),
            (objects.TORQUE_DEMAND, lambda: round(self.set_value) if self.kind is Kind.TORQUE else 0),
            (objects.RATED_TORQUE, lambda: motor.rated_torque_mnm),
            (objects.TORQUE_ACTUAL, lambda: motor.torque),
            (objects.FOLLOWING_ERROR, lambda: round(self._following_error / context.units.per_unit)),
            (objects.DEMAND_INTERNAL, lambda: wrapped(round(context.motion.position))),
            (objects.INPUTS, lambda: motor.inputs),
            (objects.SUPPORTED_MODES, lambda: sum(1 << (number - 1) for number in self._supported())),
            (objects.DEVICE_TYPE, lambda: objects.SERVO_DRIVE if motor.is_there else 0),
        ):
            numbers.read_by(index, read)

    def _connect_writers(self) -> None:
        """Several modes may look at the same object; each knows whether it is its turn."""
        together: dict[tuple[int, int], list[Callable[[int], None]]] = {}
        for mode in self._modes.values():
            for key, act in mode.writers().items():
                together.setdefault(key, []).append(act)
        for (index, subindex), several in together.items():
            self._numbers.on_write(index, _all(several), subindex)

    # ---- from the network

    def _on_control(self, word: int) -> None:
        self._is_woken = True
        before = self.machine.control_word
        self.machine.control(word)
        if self._shown_mode != NO_MODE:
            self._mode.control(word, word & ~before if self._is_moving else 0)
        self._update_halt()
        self._show()

    def _update_halt(self) -> None:
        wanted = bool(self.machine.control_word & HALT) and self._is_moving
        if wanted is self._is_halted or not self._is_moving:
            return
        self._is_halted = wanted
        if wanted:
            self._mode.halt(HALT_OPTIONS.get(self._numbers[objects.HALT_OPTION], Ramp.SLOW_DOWN))
        else:
            self._mode.go_on()

    def _on_mode(self, number: int) -> None:
        if number == NO_MODE:
            return  # CiA 402-2: no change
        if number not in self._supported():
            raise Abort(Code.INVALID_VALUE)
        if number == self._shown_mode:
            return
        self._mode.end()
        self._mode = self._modes[number]
        self._shown_mode = number
        self._context.is_limited = False
        if self._is_moving:
            self._begin_mode()
        self._mode.control(self.machine.control_word, 0)
        self._show()

    def _on_outputs(self, _written: int) -> None:
        numbers = self._numbers.numbers
        self._motor.set_outputs(numbers[objects.OUTPUTS, 1], numbers[objects.OUTPUTS, 2])

    def _supported(self) -> set[int]:
        kinds = self._motor.kinds
        return {mode.number for mode in self._modes.values() if mode.kind in kinds}

    # ---- what the state machine moves (`state_machine.Drive`)

    @property
    def is_there(self) -> bool:
        return self._motor.is_there

    @property
    def is_ready(self) -> bool:
        return self._motor.is_ready

    @property
    def is_following(self) -> bool:
        return self._motor.is_following

    @property
    def is_moving_by_itself(self) -> bool:
        return self._motor.is_stopping

    @property
    def is_at_rest(self) -> bool:
        return self._context.motion.is_done and self._is_ramp

    @property
    def error(self) -> int:
        return self._own_error or self._motor.error

    @property
    def options(self) -> Options:
        numbers = self._numbers
        return Options(
            numbers[objects.QUICK_STOP_OPTION],
            numbers[objects.SHUTDOWN_OPTION],
            numbers[objects.DISABLE_OPTION],
            numbers[objects.FAULT_OPTION],
        )

    def enable(self) -> None:
        self._motor.enable(True)

    def disable(self) -> None:
        self._motor.enable(False)
        if self._is_moving or self._is_ramp:
            self._mode.end()
        self._is_moving = self._is_ramp = self._is_halted = False

    def brake(self, ramp: Ramp) -> None:
        motion = self._context.motion
        if self._is_moving:
            self._mode.end()
            self._mode.is_halted = False
        self._is_moving = self._is_halted = False
        self._is_ramp = True
        motion.start(brake(motion.speed, self._context.ramp_limits(ramp)))

    def go_on(self) -> None:
        was_ramp, self._is_ramp = self._is_ramp, False
        self._is_moving = True
        self._following.reset()
        if not was_ramp:
            self._context.motion.stand(self._motor.position)
        if self._shown_mode != NO_MODE:
            self._begin_mode()

    def reset_fault(self, done: Callable[[], None]) -> None:
        self._own_error = 0
        self._motor.reset(done)

    def _begin_mode(self) -> None:
        self._mode.is_halted = self._is_halted = False
        self._mode.begin()
        self._update_halt()

    # ---- once a cycle

    @property
    def is_awake(self) -> bool:
        """Whether a cycle makes a difference though the motor is in the same state as before."""
        return self._is_moving or self._is_ramp or self._is_woken

    def step(self) -> None:
        """Actual values are those of this cycle; afterwards `set_value` is this cycle's."""
        context = self._context
        state, self._is_woken = self.machine.state, False
        is_guided = self._is_moving and self.kind is Kind.POSITION
        self._following_error = context.motion.position - self._motor.position if is_guided else 0.0
        self.machine.step()
        if self._is_moving and self._shown_mode != NO_MODE:
            self._mode.step()
            self.kind, self.set_value = self._mode.kind, self._mode.value
            self._watch_following()
        elif self._is_moving or self._is_ramp:
            context.motion.step(context.cycle_s)
            self.kind, self.set_value = Kind.POSITION, round(context.motion.position)
        else:
            self.kind, self.set_value = Kind.POSITION, self._motor.position
        self._is_woken |= self.machine.state is not state
        self._report()

    def _watch_following(self) -> None:
        window = self._numbers[objects.FOLLOWING_WINDOW]
        if window == objects.NO_WINDOW:
            return
        is_outside = abs(self._following_error) > window * self._context.units.per_unit
        time = self._numbers[objects.FOLLOWING_TIME]
        if self._following.update(is_outside, time, self._context.cycle_ns):
            self._own_error = FOLLOWING_ERROR

    def _report(self) -> None:
        error = self.error if self.machine.state in (State.FAULT, State.FAULT_REACTION_ACTIVE) else 0
        if error != self._reported:
            self._reported = error
            self.on_error(error)

    @property
    def status_word(self) -> int:
        motor, state = self._motor, self.machine.state
        if state is State.NOT_READY_TO_SWITCH_ON:
            return 0
        word: int = state.value | REMOTE
        if motor.is_ready:
            word |= VOLTAGE_ENABLED
        if motor.has_warning:
            word |= WARNING
        if state in _ON and self._shown_mode != NO_MODE:
            if self._context.is_limited:
                word |= INTERNAL_LIMIT
            word |= self._mode.status if self._is_moving else self._mode.halted_status
        if self._following.is_held and self._shown_mode in SHOWS_FOLLOWING_ERROR:
            word |= BIT_13
        return word

    def _show(self) -> None:
        """What a command has changed goes out with the TPDOs of this instant."""
        self._numbers.put(objects.STATUS_WORD, self.status_word)
        self._numbers.put(objects.MODE_DISPLAY, self._shown_mode)


def _all(several: list[Callable[[int], None]]) -> Callable[[int], None]:
    def act(value: int) -> None:
        for one in several:
            one(value)

    return act
