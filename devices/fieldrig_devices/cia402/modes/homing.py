"""Homing: finding the origin by switches, by the encoder's zero, or where the axis stands.

Source: CiA 402-2, chapter 'homing mode': methods 1 to 6, 17 to 22, 33 to 35 and 37, as the figures there show them.
A method is a row of ways, each with a direction, a speed and what ends it; a way whose end is there already is passed.
Left out: methods 7 to 14 and 23 to 30, which turn round at limit switches.  The encoder's zero is where its position is
a whole number of revolutions.  A halt stops it, and it goes on after that; a fallen bit 4 ends it.
"""

from enum import Enum, IntEnum
from typing import Final, NamedTuple

from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.mode import BIT_12, BIT_13, TARGET_REACHED, Mode
from fieldrig_devices.motion.profile import Limits, brake, change_speed

START: Final = 0x0010
ATTAINED: Final = BIT_12
ERROR: Final = BIT_13


class Switch(IntEnum):
    """Bits of 60FDh."""

    NEGATIVE = 0x1
    POSITIVE = 0x2
    HOME = 0x4
    INDEX = 0x0
    """None of the inputs: the encoder's zero."""


class Way(NamedTuple):
    direction: int
    is_fast: bool
    """6099h sub-index 1, else 2."""
    switch: Switch
    ends_when: bool = True


_UP, _DOWN = 1, -1
NEGATIVE_LIMIT: Final = (Way(_DOWN, True, Switch.NEGATIVE), Way(_UP, False, Switch.NEGATIVE, False))
POSITIVE_LIMIT: Final = (Way(_UP, True, Switch.POSITIVE), Way(_DOWN, False, Switch.POSITIVE, False))
HOME_FROM_ABOVE: Final = (Way(_UP, True, Switch.HOME), Way(_DOWN, False, Switch.HOME, False))
HOME_ONTO_UP: Final = (Way(_DOWN, True, Switch.HOME, False), Way(_UP, False, Switch.HOME))
HOME_FROM_BELOW: Final = (Way(_DOWN, True, Switch.HOME), Way(_UP, False, Switch.HOME, False))
HOME_ONTO_DOWN: Final = (Way(_UP, True, Switch.HOME, False), Way(_DOWN, False, Switch.HOME))
INDEX_UP: Final = (Way(_UP, False, Switch.INDEX),)
INDEX_DOWN: Final = (Way(_DOWN, False, Switch.INDEX),)
# Figures of the methods: a switch whose edge counts, then the next zero of the encoder, or nothing.
WAYS: Final[dict[int, tuple[Way, ...]]] = {
    1: NEGATIVE_LIMIT + INDEX_UP,
    2: POSITIVE_LIMIT + INDEX_DOWN,
    3: HOME_FROM_ABOVE + INDEX_DOWN,
    4: HOME_ONTO_UP + INDEX_UP,
    5: HOME_FROM_BELOW + INDEX_UP,
    6: HOME_ONTO_DOWN + INDEX_DOWN,
    17: NEGATIVE_LIMIT,
    18: POSITIVE_LIMIT,
    19: HOME_FROM_ABOVE,
    20: HOME_ONTO_UP,
    21: HOME_FROM_BELOW,
    22: HOME_ONTO_DOWN,
    33: INDEX_DOWN,
    34: INDEX_UP,
    35: (),
    37: (),
}


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
        self._ways: tuple[Way, ...] = ()
        self._is_under_way = False
        self._last = 0
        """The actual position of the cycle before."""
        self._home = 0.0

    def begin(self) -> None:
        self._is_begun = True
        self.come_to_rest()
        self.stage = Stage.DONE if self.context.is_homed else Stage.IDLE

    def end(self) -> None:
        self._is_begun = False
        self.stage = Stage.IDLE

    def control(self, word: int, rising: int) -> None:
        if rising & START and self._is_begun:
            self._start()
        elif not word & START and self.stage is Stage.UNDER_WAY:
            self._stop(Stage.IDLE)

    def _start(self) -> None:
        context = self.context
        self._ways = WAYS.get(context.objects[objects.HOMING_METHOD], ())
        self._last = context.motor.position
        if context.objects[objects.HOMING_METHOD] not in WAYS:
            self.stage = Stage.FAILED
            return
        context.is_homed = False
        self.stage = Stage.UNDER_WAY
        self._is_under_way = False
        if not self.is_halted:
            self._advance()

    def go_on(self) -> None:
        super().go_on()
        if self.stage is Stage.UNDER_WAY:
            self._is_under_way = False
            self._advance()

    def _limits(self, is_fast: bool) -> Limits:
        context = self.context
        speed = context.objects.numbers[objects.HOMING_SPEED, 1 if is_fast else 2]
        rate = context.objects[objects.HOMING_ACCELERATION]
        return context.limits(speed, rate, rate)

    def _is_at_end(self, way: Way) -> bool:
        """Also notes where."""
        position = self.context.motor.position
        if way.switch is not Switch.INDEX:
            self._home = position
            return bool(self.context.motor.inputs & way.switch) is way.ends_when
        turn = self.context.motor.revolution
        if not self._is_under_way:
            return False
        if way.direction > 0:
            self._home = position // turn * turn
            return self._last < self._home
        self._home = -(-position // turn) * turn
        return self._home < self._last

    def _advance(self) -> None:
        """To the first way that has not come to its end."""
        while self._ways and self._is_at_end(self._ways[0]):
            self._ways = self._ways[1:]
            self._is_under_way = False
        if not self._ways:
            self._find()
        elif not self._is_under_way:
            way = self._ways[0]
            limits = self._limits(way.is_fast)
            motion = self.context.motion
            self._is_under_way = True
            motion.start(change_speed(motion.speed, way.direction * limits.speed, limits))

    def _find(self) -> None:
        context = self.context
        if not WAYS[context.objects[objects.HOMING_METHOD]]:
            self._home = context.motion.position
        context.set_home(self._home)
        self._stop(Stage.STOPPING)

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
            if self._is_at_wrong_end():
                self._stop(Stage.FAILED_MOVING)
            else:
                self._advance()
        self._last = context.motor.position
        context.motion.step(context.cycle_s)
        self._settle()

    def _is_at_wrong_end(self) -> bool:
        """On a limit switch that the method doesn't look for."""
        way = self._ways[0]
        wrong = Switch.POSITIVE if way.direction > 0 else Switch.NEGATIVE
        return way.switch is not wrong and bool(self.context.motor.inputs & wrong)

    @property
    def status(self) -> int:
        if self.is_halted and self.stage is Stage.UNDER_WAY:
            return self.halted_status
        return self.stage.value
