"""The part that the TMP and the PMP generator share: a position that a motion leads on, and its life in a pipe."""

from abc import ABC, abstractmethod

from fieldrig_devices.pam.pipes.block import wrapped


class Generator(ABC):
    """A source of pipes.  Positions are in user units, and within the period if there is one."""

    def __init__(self, initial_position: float, position_period: float | None) -> None:
        self.initial_position, self.position_period = initial_position, position_period
        self.is_active = False
        self.period_s = 0.0
        self._base = initial_position
        """The position at which the present motion began."""
        self._periods = 0
        """Number of periods since then."""

    @property
    def _seconds(self) -> float:
        return self._periods * self.period_s

    @abstractmethod
    def _moved(self) -> float:
        """Return the way of the present motion up to now."""

    @abstractmethod
    def _rest(self) -> None:
        """Forget the present motion."""

    @property
    def position(self) -> float:
        """The present position; 0 while the block is not active (PAML-634)."""
        return wrapped(self._absolute, self.position_period) if self.is_active else 0.0

    @property
    def _absolute(self) -> float:
        return self._base + self._moved()

    def start(self, period_s: float) -> None:
        """The pipe is activated with this period in seconds: the position is INITIAL_POSITION (PAML-607)."""
        self.period_s, self.is_active = period_s, True
        self._rest()
        self._base, self._periods = self.initial_position, 0

    def stop(self) -> None:
        self.is_active = False

    def step(self) -> float:
        """Go on for a period, and return the position."""
        self._periods += 1
        return self.position

    def set_position(self, position: float) -> None:
        """Call the present position `position`: a step of an active generator, else its next start (PAML-606, 633)."""
        if self.is_active:
            self._base += position - self._absolute
        else:
            self.initial_position = position
