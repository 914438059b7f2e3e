"""The distributor: it lets a pipe compute only in one of several periods of its network (PAML-540 to PAML-542)."""

from fieldrig_devices.pam.pipes.block import Block


class Distributor(Block):
    """A distributor, which computes in every period if `divisor` is 0 or 1 (E-23)."""

    def __init__(self, divisor: int, shift: int) -> None:
        super().__init__()
        self.divisor, self.shift = max(divisor, 1), shift

    @property
    def is_at_rest(self) -> bool:
        return True

    def computes_in(self, number: int) -> bool:
        """True if the pipe computes in this period of the network; the first has the number 0."""
        return number % self.divisor == self.shift

    def transform(self, value: float) -> float:
        return value
