"""The amplifier: y = GAIN (x + OFFSET), with slopes for changes of both (PAML-430 to PAML-436)."""

from fieldrig_devices.pam.pipes.block import Block, Slewed


class Amplifier(Block):
    """`gain_slope` is in 1/s, `offset_slope` in units a second; None is MAX."""

    def __init__(self, gain: float, offset: float, gain_slope: float | None, offset_slope: float | None) -> None:
        super().__init__()
        self.gain, self.offset = Slewed(gain, gain_slope), Slewed(offset, offset_slope)

    @property
    def ready(self) -> bool:
        return self.gain.is_there and self.offset.is_there

    def set_gain(self, gain: float) -> None:
        self.gain.set(gain, at_once=not self.is_active)

    def set_offset(self, offset: float) -> None:
        self.offset.set(offset, at_once=not self.is_active)

    def stop(self) -> None:
        super().stop()
        self.gain.finish()
        self.offset.finish()

    def transform(self, value: float) -> float:
        return self.gain.step(self.period_s) * (value + self.offset.step(self.period_s))
