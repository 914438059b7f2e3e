"""The amplifier: y = GAIN (x + OFFSET), with slopes for changes of both (PAML-430 to PAML-436)."""

from fieldrig_devices.pam.pipes.block import Block, Slewed


class Amplifier(Block):
    """An amplifier; `gain_slope` is in 1/s, `offset_slope` in units a second; None is MAX.

    In a flow with a period the amplifier counts the periods that pass, so its output has no step where its input
    begins again (G-29).  With `unwraps` False it takes each value as it is.  The offset slope is that of OFFSET, which
    is in front of the gain (G-30).
    """

    def __init__(
        self,
        gain: float,
        offset: float,
        gain_slope: float | None = None,
        offset_slope: float | None = None,
        *,
        unwraps: bool = True,
    ) -> None:
        super().__init__()
        self.gain, self.offset = Slewed(gain, gain_slope), Slewed(offset, offset_slope)
        self._unwraps = unwraps
        self._last: float | None = None
        self._passed = 0.0

    @property
    def ready(self) -> bool:
        return self.gain.is_there and self.offset.is_there

    is_at_rest = ready

    @property
    def outgoing_period(self) -> float | None:
        return None if self._unwraps else self.period

    def set_gain(self, gain: float) -> None:
        self.gain.set(gain, at_once=not self.is_active)

    def set_offset(self, offset: float) -> None:
        self.offset.set(offset, at_once=not self.is_active)

    def start(self, period_s: float) -> None:
        super().start(period_s)
        self._last, self._passed = None, 0.0

    def stop(self) -> None:
        super().stop()
        self.gain.finish()
        self.offset.finish()

    def transform(self, value: float) -> float:
        if self.period is not None and self._unwraps:
            value = self._unwrapped(value, self.period)
        gain, offset = self.gain, self.offset
        if gain.value == gain.target and offset.value == offset.target:
            return gain.value * (value + offset.value)
        return gain.step(self.period_s) * (value + offset.step(self.period_s))

    def _unwrapped(self, value: float, period: float) -> float:
        last, self._last = self._last, value
        if last is not None and not -period / 2 <= value - last <= period / 2:
            self._passed -= period * round((value - last) / period)
        return value + self._passed
