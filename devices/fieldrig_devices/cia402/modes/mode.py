"""What a mode of operation is: it gives set values, takes bits 4 to 9 of the control word, and shows bits 10 to 15.

Source: CiA 402-2, table 'control word' and the chapters of the modes.
"""

from collections.abc import Callable
from typing import ClassVar, Final

from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.motor import Kind
from fieldrig_devices.cia402.options import Ramp
from fieldrig_devices.cia402.pace import NO_BAND
from fieldrig_devices.motion.profile import brake

HALT: Final = 0x0100
"""Bit of the control word."""
TARGET_REACHED: Final = 0x0400
BIT_12: Final = 0x1000
BIT_13: Final = 0x2000
"""Bits of the status word; 12 and 13 mean something else in each mode."""


class Mode:
    """Begins when the axis is enabled in it, or changes to it; `step` follows once a cycle, but not while a ramp is
    driven.  The set value is `context.motion`, unless `value` is overridden."""

    number: ClassVar[int]
    """In 6060h; bit `number` - 1 of 6502h."""
    kind: ClassVar[Kind] = Kind.POSITION
    """Which set values it needs."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.is_halted = False
        self.gives = self.kind
        """What `value` is in this cycle."""

    def begin(self) -> None:
        """From where the motion is."""

    def end(self) -> None:
        """Another mode, or not enabled any more."""

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        """Objects that mean something each time they are written, by index and sub-index."""
        return {}

    def control(self, word: int, rising: int) -> None:
        """Bits 4, 5, 6 and 9; also while not enabled, so that edges are seen."""

    def halt(self, ramp: Ramp) -> None:
        self.is_halted = True
        self.brake(ramp)

    def brake(self, ramp: Ramp) -> None:
        self.context.motion.start(brake(self.context.motion.speed, self.context.ramp_limits(ramp)))

    def come_to_rest(self) -> None:
        """For a mode that begins while the axis still moves in another one."""
        motion = self.context.motion
        motion.start(brake(motion.speed, self.context.profile_limits()))

    def go_on(self) -> None:
        """After a halt."""
        self.is_halted = False

    def step(self) -> None:
        self.context.motion.step(self.context.cycle_s)

    @property
    def band(self) -> tuple[float, float]:
        """Actual velocities, without both ends, with which `step` does no more than `Mode.step`, and goes on doing so
        until something is written or an input is on."""
        return NO_BAND

    @property
    def value(self) -> float:
        """The set value of this cycle."""
        return round(self.context.motion.position)

    @property
    def status(self) -> int:
        """Bits 10, 12 and 13."""
        return 0

    @property
    def halted_status(self) -> int:
        """Bit 10 while halted: standing."""
        context = self.context
        return TARGET_REACHED if context.motion.is_done and context.is_standing(context.motor.velocity) else 0
