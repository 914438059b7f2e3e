"""The position loop: it converts the tracking error into the voltage of a drive's current reference.

Source: manual 3.2, @ParX[10] to [13]; digest chapter 12, which gives the form: feed-forward of the reference's speed,
and a PID.  The integrator is frozen while the output is at its limit and the error drives it further out.
"""

from typing import Final

from fieldrig_devices.arp.motion.setup import Setup

MAXIMUM_V: Final = 10.0


class PositionLoop:
    __slots__ = ("_last", "_setup", "_sum")

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._sum = self._last = 0.0

    def configure(self, setup: Setup) -> None:
        self._setup = setup

    def reset(self, error: float = 0.0) -> None:
        self._sum, self._last = 0.0, error

    def volts(self, error: float, speed: float, seconds: float) -> float:
        """Output voltage for one sample, `seconds` after the last."""
        setup = self._setup
        total = self._sum + error * seconds
        volts = (
            setup.feed_forward * speed + setup.kp * error + setup.ki * total + setup.kd * (error - self._last) / seconds
        )
        self._last = error
        if -MAXIMUM_V <= volts <= MAXIMUM_V:
            self._sum = total
            return volts * setup.output_sign
        if volts * error < 0:
            self._sum = total
        return (MAXIMUM_V if volts > 0 else -MAXIMUM_V) * setup.output_sign
