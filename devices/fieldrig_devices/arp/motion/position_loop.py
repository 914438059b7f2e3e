"""The position loop: it converts the tracking error into the voltage of a drive's current reference.

Source: manual 3.2, @ParX[10] to [13]; digest chapter 12, which gives the form: feed-forward of the reference's speed,
and a PID.  The integrator is frozen while the output is at its limit and the error drives it further out.  `Arrival`
says when the error has stayed inside the window for the dwell time.
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


class Arrival:
    """Arrival of one axis.  `is_awaited` is False if there is nothing to check.

    Source: manual 3.2, @ParX[15], [16], and 4.6 (F260); digest chapter 12.  Once an axis has arrived, it stays so until
    it moves again.
    """

    __slots__ = ("_inside_ns", "is_awaited")

    def __init__(self) -> None:
        self.expect()

    def expect(self) -> None:
        """Await an arrival from now on."""
        self.is_awaited = True
        self._inside_ns: int | None = None

    def forget(self) -> None:
        self.is_awaited = False

    def check(self, now_ns: int, is_inside: bool, dwell_ns: int) -> bool:
        """Check once per control loop while an arrival is awaited.  True when the axis arrives."""
        if not is_inside:
            self._inside_ns = None
            return False
        if self._inside_ns is None:
            self._inside_ns = now_ns
        self.is_awaited = now_ns - self._inside_ns < dwell_ns
        return not self.is_awaited
