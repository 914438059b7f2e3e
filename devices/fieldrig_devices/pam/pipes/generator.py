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
        self._end: float | None = initial_position
        """The position at which it ends, or None if it keeps a speed."""
        self._end_s = 0.0
        """Time from its beginning to its end."""
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
        return self._at(self._seconds)

    def _at(self, seconds: float) -> float:
        """Return the position after this time.

        At the end it is the target itself, without the rounding of the way there, so that `position = 90` holds.
        """
        if self._end is not None and seconds >= self._end_s:
            return self._end
        return self._base + self._moved(seconds)

    def _begin(self, base: float, duration_s: float, end: float | None, ready_s: float | None = None) -> None:
        """Begin the motion that `_moved` describes from now on, at the position `base`."""
        self._base, self._periods = base, 0
        self._end_s, self._end = duration_s, end
        self._ready_s = duration_s if ready_s is None else ready_s

    def _way_to(self, position: float) -> float:
        """Return the distance to a position: the numeric difference, over several periods if that is so (G-14)."""
        difference = position - self.position
        return nearest(difference, self.position_period) if self.takes_shorter_way else difference

    def start(self, period_s: float) -> None:
        """Begin at INITIAL_POSITION with this period in seconds, as the pipe is activated (PAML-607)."""
        self.period_s, self.is_active = period_s, True
        self._rest()
        self._begin(self.initial_position, 0.0, self.initial_position)

    def stop(self) -> None:
        self.is_active = False

    def step(self) -> float:
        """Go on for a period, and return the value of the flow."""
        self._periods += 1
        return wrapped(self._at(self._seconds + self.lead_s), self.position_period)

    def set_position(self, position: float) -> None:
        """Set the present position of an active generator by a step, else that of its next start (PAML-606, 633)."""
        if not self.is_active:
            self.initial_position = position
            return
        step = position - self._absolute
        self._base += step
        if self._end is not None:
            self._end = position if self._seconds >= self._end_s else self._end + step
