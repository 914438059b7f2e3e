"""The part that the TMP and the PMP generator share: a position that a motion leads on, and its life in a pipe."""

import math
from abc import ABC, abstractmethod

from fieldrig_devices.pam.pipes.block import nearest, wrapped


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
        self.lead_s = 0.0
        """Time by which the flow is ahead of the position, with ANTI_DELAY (PAML-635)."""
        self.takes_shorter_way = False
        """True if an absolute move in a periodic system takes the shorter way round (G-14)."""
        self.run_is_ready_at_speed = True
        """True if a run is carried out when its speed is reached, False if it is only when it ends (G-38)."""
        self._ready_s = 0.0
        """Time from the beginning of the present motion until the command is carried out."""

    @property
    def ready(self) -> bool:
        """True if the last command has been carried out."""
        return self._seconds >= self._ready_s

    def _run_is_ready_s(self, speed: float, duration_s: float) -> float:
        """Return the time from the beginning of a run until it is carried out."""
        return duration_s if self.run_is_ready_at_speed or not speed else math.inf

    @property
    def outgoing_period(self) -> float | None:
        return self.position_period

    @property
    def _seconds(self) -> float:
        return self._periods * self.period_s

    @abstractmethod
    def _moved(self, seconds: float) -> float:
        """Return the way of the present motion after this time."""

    @abstractmethod
    def _rest(self) -> None:
        """Forget the present motion."""

    @property
    def position(self) -> float:
        """The present position; 0 while the block is not active (PAML-634)."""
        return wrapped(self._absolute, self.position_period) if self.is_active else 0.0

    @property
    def _absolute(self) -> float:
        return self._base + self._moved(self._seconds)

    def _way_to(self, position: float) -> float:
        """Return the distance to a position: the numeric difference, over several periods if that is so (G-14)."""
        difference = position - self.position
        return nearest(difference, self.position_period) if self.takes_shorter_way else difference

    def start(self, period_s: float) -> None:
        """Begin at INITIAL_POSITION with this period in seconds, as the pipe is activated (PAML-607)."""
        self.period_s, self.is_active = period_s, True
        self._rest()
        self._base, self._periods, self._ready_s = self.initial_position, 0, 0.0

    def stop(self) -> None:
        self.is_active = False

    def step(self) -> float:
        """Go on for a period, and return the value of the flow."""
        self._periods += 1
        return wrapped(self._base + self._moved(self._seconds + self.lead_s), self.position_period)

    def set_position(self, position: float) -> None:
        """Set the present position of an active generator by a step, else that of its next start (PAML-606, 633)."""
        if self.is_active:
            self._base += position - self._absolute
        else:
            self.initial_position = position
