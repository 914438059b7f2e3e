"""The derivator: the change of the flow per second (PAML-530 to PAML-533)."""

from fieldrig_devices.pam.pipes.block import Block, is_same, nearest


class Derivator(Block):
    """A derivator; `value_period` is the period of the flow in its units, or None."""

    def __init__(self, value_period: float | None) -> None:
        super().__init__()
        self.value_period = value_period
        self._last: float | None = None

    @property
    def is_at_rest(self) -> bool:
        return is_same(self.value, 0.0)

    @property
    def outgoing_period(self) -> float | None:
        return None

    def start(self, period_s: float) -> None:
        super().start(period_s)
        self._last = None

    def transform(self, value: float) -> float:
        last, self._last = self._last, value
        return 0.0 if last is None else nearest(value - last, self.value_period) / self.period_s
