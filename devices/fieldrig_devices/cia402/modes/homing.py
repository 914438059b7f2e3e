"""Homing: finding the origin by switches, by the encoder's zero, or where the axis stands.

Source: CiA 402-2, chapter 'homing mode'; the methods are the table in `homing_methods`.  An edge counts only in the
direction of its way, so a switch that was overrun is found again on the way back.  The encoder's zero is where its
position is a whole number of revolutions.  After a halt the method begins anew; a fallen bit 4 ends it.
"""

from collections.abc import Callable
from enum import Enum
from typing import Final

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.homing_methods import LIMITS, METHODS, Way
from fieldrig_devices.cia402.modes.mode import BIT_12, BIT_13, TARGET_REACHED, Mode
from fieldrig_devices.cia402.motor import passed_zero
from fieldrig_devices.motion.profile import Limits, brake, change_speed

NO_HOMING: Final = 0
"""Of 6098h: none is required.  The origin stays, and there is nothing to search for."""
START: Final = 0x0010
ATTAINED: Final = BIT_12
ERROR: Final = BIT_13


class Stage(Enum):
    IDLE = TARGET_REACHED
    """Not started, or interrupted."""
    UNDER_WAY = 0
    STOPPING = ATTAINED
    """Home is found, and the axis not at rest."""
    DONE = ATTAINED | TARGET_REACHED
    FAILED_MOVING = ERROR
    FAILED = ERROR | TARGET_REACHED


class Homing(Mode):
    number = 6

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.stage = Stage.IDLE
        self._is_begun = False
        self._method: tuple[Way, ...] = ()
        self._ways: tuple[Way, ...] = ()
        """Those that have not come to their ends."""
        self._last = self._inputs = 0
        """Actual position and 60FDh in the cycle before."""
        self._home = 0.0

    def begin(self) -> None:
        self._is_begun = True
        self.come_to_rest()
        self.stage = Stage.DONE if self.context.is_homed else Stage.IDLE

    def end(self) -> None:
        self._is_begun = False
        self.stage = Stage.IDLE

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        return {(objects.HOMING_METHOD, 0): _check}

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
        self._method = METHODS.get(number, ())
        context.is_homed = False
        self.stage = Stage.UNDER_WAY
        if not self.is_halted:
            self._begin_method()

    def go_on(self) -> None:
        super().go_on()
        if self.stage is Stage.UNDER_WAY:
            self._begin_method()

    def _begin_method(self) -> None:
        """Switches that are there already need not be looked for."""
        motor = self.context.motor
        self._ways, self._last, self._inputs = self._method, motor.position, motor.inputs
        self._home = self.context.motion.position
        while self._ways and self._is_there(self._ways[0]):
            self._ways = self._ways[1:]
        self._go()

    def _is_there(self, way: Way) -> bool:
        return way.switch is not None and bool(self._inputs & way.switch) is way.ends_when

    def _limits(self, is_fast: bool) -> Limits:
        context = self.context
        speed = context.objects.numbers[objects.HOMING_SPEED, 1 if is_fast else 2]
        rate = context.objects[objects.HOMING_ACCELERATION]
        return context.limits(speed, rate, rate)

    def _go(self) -> None:
        """The first way that is left."""
        if not self._ways:
            self.context.set_home(self._home)
            self._stop(Stage.STOPPING)
            return
        way, motion = self._ways[0], self.context.motion
        limits = self._limits(way.is_fast)
        motion.start(change_speed(motion.speed, way.direction * limits.speed, limits))

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
        """For what ends the way."""
        way = self._ways[0]
        limit = LIMITS[way.direction]
        is_edge = self._is_zero(way, position) if way.switch is None else self._is_edge(way, position, inputs)
        self._last, self._inputs = position, inputs
        if is_edge:
            self._ways = self._ways[1:]
            self._go()
        elif inputs & limit and way.switch is not limit:
            self._turn(way)

    def _turn(self, way: Way) -> None:
        if way.turns_round:
            self._ways = (way._replace(direction=-way.direction, turns_round=False), *self._ways[1:])
            self._go()
        else:
            self._stop(Stage.FAILED_MOVING)

    def _is_edge(self, way: Way, position: int, inputs: int) -> bool:
        assert way.switch is not None
        self._home = position
        is_on, was_on = bool(inputs & way.switch), bool(self._inputs & way.switch)
        return is_on is way.ends_when and was_on is not is_on and (position - self._last) * way.direction > 0

    def _is_zero(self, way: Way, position: int) -> bool:
        zero = passed_zero(self._last, position, self.context.motor.revolution)
        if zero is None or (position - self._last) * way.direction < 0:
            return False
        self._home = zero
        return True

    @property
    def status(self) -> int:
        if self.is_halted and self.stage is Stage.UNDER_WAY:
            return self.halted_status
        return self.stage.value


def _check(method: int) -> None:
    if method not in METHODS and method != NO_HOMING:
        raise Abort(Code.INVALID_VALUE)
