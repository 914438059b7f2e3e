"""The base of all modes of operation, which give set values and take bits 4 to 9 of the control word.

A mode shows bits 10, 12 and 13 of the status word.

Source: CiA 402-2, table 'control word' and the chapters of the modes.
"""

from collections.abc import Callable
from typing import ClassVar, Final

from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.motor import Kind
from fieldrig_devices.cia402.options import Ramp
from fieldrig_devices.cia402.pace import NO_BAND
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.motion.smooth import brake

HALT: Final = 0x0100
"""Bit of the control word."""
TARGET_REACHED: Final = 0x0400
BIT_12: Final = 0x1000
BIT_13: Final = 0x2000
"""Bits of the status word; the meaning of 12 and 13 depends on the mode."""
FOLLOWS: Final = BIT_12
"""Bit 12 in the cyclic synchronous modes: the drive follows the command value."""


class Mode:
    """One mode of operation.  `begin` is called when the axis is enabled in it or changes to it, then `step` once per
    cycle except during a ramp.  The set value is that of `context.motion`, unless `value` is overridden."""

    number: ClassVar[int]
    """Value in 6060h; the mode is bit `number` - 1 of 6502h."""
    kind: ClassVar[Kind] = Kind.POSITION
    """The kind of set values that the mode needs."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.is_halted = False
        self.gives = self.kind
        """The kind of `value` in this cycle."""

    def begin(self) -> None:
        """Start at the present position and speed of the motion."""

    def end(self) -> None:
        """Stop giving set values, because of another mode or because the axis is disabled."""

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        """Handlers of objects that act each time they are written, by index and sub-index."""
        return {}

    def control(self, word: int, rising: int) -> None:
        """Take over bits 4, 5, 6 and 9; called while disabled too, so that no edge is missed."""

    def halt(self, ramp: Ramp) -> None:
        self.is_halted = True
        self.brake(ramp)

    def brake(self, ramp: Ramp) -> None:
        motion = self.context.motion
        motion.start(brake(motion.speed, self.ramp_limits(ramp), motion.acceleration))

    def ramp_limits(self, ramp: Ramp) -> Limits:
        """The profile limits of a ramp that brings the axis to rest in this mode."""
        return self.context.ramp_limits(ramp)

    def come_to_rest(self) -> None:
        """Bring the axis to rest if it still moves from another mode."""
        motion = self.context.motion
        motion.start(brake(motion.speed, self.context.profile_limits(), motion.acceleration))

    def go_on(self) -> None:
        """Resume after a halt."""
        self.is_halted = False

    def step(self) -> None:
        self.context.motion.step(self.context.cycle_s)

    @property
    def behind(self) -> float:
        """How far the motion is behind the set positions of a master, in increments; 0 in a mode with a generator."""
        return 0.0

    @property
    def band(self) -> tuple[float, float]:
        """Open interval of actual velocities at which `step` does no more than `Mode.step`.

        It is valid until an object is written or an input switches on.  Only a mode that gives positions has one.
        """
        return NO_BAND

    @property
    def value(self) -> float:
        """The set value of this cycle."""
        return round(self.context.motion.position)

    @property
    def status(self) -> int:
        """Bits 10, 12 and 13 of the status word."""
        return 0

    @property
    def halted_status(self) -> int:
        """Bit 10 of the status word while halted: set when the axis is at rest."""
        context = self.context
        return TARGET_REACHED if context.motion.is_done and context.is_standing(context.motor.velocity) else 0
