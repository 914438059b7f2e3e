"""Homing: finds the origin by switches, by the encoder zero, or at the present position.

Source: CiA 402-2, chapter 'homing mode'; the methods are the table in `homing_methods`.  An edge counts only in the
direction of its move, so a switch that was overrun is found again on the way back.  The encoder zero is at each whole
number of revolutions, and a mechanical stop is found by the torque.  After a halt the method starts again; clearing
bit 4 ends it.
"""

from collections.abc import Callable
from enum import Enum
from typing import Final

from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.behaviour import HomingBit
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.homing_methods import ALL_METHODS, LIMITS, Move
from fieldrig_devices.cia402.modes.mode import BIT_12, BIT_13, TARGET_REACHED, Mode
from fieldrig_devices.cia402.motor import passed_zero
from fieldrig_devices.cia402.permitted import NO_HOMING, homing_method
from fieldrig_devices.motion.profile import Limits, brake, change_speed

START: Final = 0x0010
ATTAINED: Final = BIT_12
ERROR: Final = BIT_13


class Stage(Enum):
    IDLE = TARGET_REACHED
    """Homing is not started, or was interrupted."""
    UNDER_WAY = 0
    STOPPING = ATTAINED
    """The home position is found, and the axis is not yet at rest."""
    DONE = ATTAINED | TARGET_REACHED
    FAILED_MOVING = ERROR
    FAILED = ERROR | TARGET_REACHED


class Homing(Mode):
    number = 6

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.stage = Stage.IDLE
        self._is_begun = False
        self._method: tuple[Move, ...] = ()
        self._moves: tuple[Move, ...] = ()
        """Moves that have not ended yet."""
        self._last = self._inputs = 0
        """Actual position and digital inputs (60FDh) of the previous cycle."""
        self._way = 0
        """Increments of the last cycle that had any; its sign is the direction of the shaft."""
        self._home = 0.0

    def begin(self) -> None:
        self._is_begun = True
        self.come_to_rest()
        self.stage = Stage.DONE if self.context.is_homed else Stage.IDLE

    def end(self) -> None:
        self._is_begun = False
        self.stage = Stage.IDLE

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        return {(objects.HOMING_METHOD, 0): homing_method(self.context.behaviour).check}

    def control(self, word: int, rising: int) -> None:
        if rising & START and self._is_begun:
            self._start()
        elif not word & START and self.stage is Stage.UNDER_WAY:
            self._stop(Stage.IDLE)

    def _start(self) -> None:
        context = self.context
        number = context.objects[objects.HOMING_METHOD]
        if number == NO_HOMING:
            self._stop(Stage.STOPPING)
            return
        self._method = ALL_METHODS.get(number, ())
        context.is_homed = False
        self.stage = Stage.UNDER_WAY
        if not self.is_halted:
            self._begin_method()

    def go_on(self) -> None:
        super().go_on()
        if self.stage is Stage.UNDER_WAY:
            self._begin_method()

    def _begin_method(self) -> None:
        """Start the method, without the moves to switches that are already reached."""
        motor = self.context.motor
        self._moves, self._last, self._inputs, self._way = self._method, motor.position, motor.inputs, 0
        self._home = self.context.motion.position
        while self._moves and self._is_there(self._moves[0]):
            self._moves = self._moves[1:]
        self._go()

    def _is_there(self, move: Move) -> bool:
        return move.switch is not None and bool(self._inputs & move.switch) is move.ends_when

    def _limits(self, is_fast: bool) -> Limits:
        context = self.context
        speed = context.objects.numbers[objects.HOMING_SPEED, 1 if is_fast else 2]
        rate = context.objects[objects.HOMING_ACCELERATION]
        return context.limits(speed, rate, rate)

    def _go(self) -> None:
        """Start the next move, or finish if there is none."""
        if not self._moves:
            self.context.set_home(self._home)
            self._stop(Stage.STOPPING)
            return
        move, motion = self._moves[0], self.context.motion
        limits = self._limits(move.is_fast)
        motion.start(change_speed(motion.speed, move.direction * limits.speed, limits))

    def _stop(self, stage: Stage) -> None:
        self.stage = stage
        motion = self.context.motion
        motion.start(brake(motion.speed, self._limits(True)))
        self._settle()

    def _settle(self) -> None:
        if self.context.motion.is_done and self.context.is_standing(self.context.motor.velocity):
            self.stage = {Stage.STOPPING: Stage.DONE, Stage.FAILED_MOVING: Stage.FAILED}.get(self.stage, self.stage)

    def step(self) -> None:
        context = self.context
        if self.stage is Stage.UNDER_WAY and not self.is_halted:
            self._look(context.motor.position, context.motor.inputs)
        context.motion.step(context.cycle_s)
        self._settle()

    def _look(self, position: int, inputs: int) -> None:
        """Check whether the present move has ended."""
        move = self._moves[0]
        limit = LIMITS[move.direction]
        self._way = position - self._last or self._way  # at a slow speed, not each cycle has a whole increment
        if move.finds_stop:
            is_edge = self._is_at_stop(move, position)
        else:
            is_edge = self._is_zero(move, position) if move.switch is None else self._is_edge(move, position, inputs)
        self._last, self._inputs = position, inputs
        if is_edge:
            self._moves = self._moves[1:]
            self._go()
        elif inputs & limit and move.switch is not limit:
            self._turn(move)

    def _turn(self, move: Move) -> None:
        if move.turns_round:
            self._moves = (move._replace(direction=-move.direction, turns_round=False), *self._moves[1:])
            self._go()
        else:
            self._stop(Stage.FAILED_MOVING)

    def _is_edge(self, move: Move, position: int, inputs: int) -> bool:
        assert move.switch is not None
        self._home = position
        is_on, was_on = bool(inputs & move.switch), bool(self._inputs & move.switch)
        # A switch at whose very edge the axis stands opens before the first whole increment.
        return is_on is move.ends_when and was_on is not is_on and self._way * move.direction >= 0

    def _is_at_stop(self, move: Move, position: int) -> bool:
        """True if the torque pushes the axis against something; the motion then begins again from there."""
        context = self.context
        if context.motor.torque * move.direction < context.behaviour.homing_torque:
            return False
        self._home = position
        context.motion.stand(position)
        return True

    def _is_zero(self, move: Move, position: int) -> bool:
        zero = passed_zero(self._last, position, self.context.motor.revolution)
        if zero is None or (position - self._last) * move.direction < 0:
            return False
        self._home = zero
        return True

    @property
    def status(self) -> int:
        if self.is_halted and self.stage is Stage.UNDER_WAY:
            return self.halted_status
        if self._is_bit_10_hidden:
            return self.stage.value & ~TARGET_REACHED
        return self.stage.value

    @property
    def _is_bit_10_hidden(self) -> bool:
        bit = self.context.behaviour.homing_bit
        return bit is HomingBit.NEVER or (bit is HomingBit.AFTER and self.stage is Stage.IDLE)
