"""The latch input of an axis: an edge captures the position once if it is armed.

Source: manual 4.2.1, 4.6 (F265, F266); digest chapter 8.2.  The input is sampled in each control loop, so the position
is that of the loop that sees the edge.
"""

from fieldrig_devices.arp.motion.flags import AxisFlag, AxisFlags


class Latch:
    def __init__(self, flags: AxisFlags) -> None:
        self._flags = flags
        self.level: int | None = None
        self.rising = self.falling = 0.0

    def take(self, level: int, reading: float) -> None:
        """Handle a changed input.  The first level that is seen is not an edge."""
        is_first, self.level = self.level is None, level
        arm = AxisFlag.ARM_RISING if level else AxisFlag.ARM_FALLING
        if is_first or not self._flags[arm]:
            return
        if level:
            self.rising = reading
        else:
            self.falling = reading
        self._flags[arm] = 0
