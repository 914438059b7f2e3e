"""A small DC motor with a pulse sensor: its position in half pulses, and the instant of each of them.

Positions are in pulses, speeds in pulses per second.  The motor runs up to its speed, and coasts to rest, with a
constant acceleration.  The sensor is high in the first half of each pulse, so a pulse has one rising edge in either
direction.
"""

from dataclasses import dataclass
from math import ceil, floor, inf

from fieldrig.clock import NEVER_NS, S
from fieldrig_devices.plants.driven import seconds_to


@dataclass(frozen=True, slots=True)
class MotorData:
    speed: float
    run_up_s: float
    coast_s: float
    low: float = -inf
    high: float = inf
    """Positions of the mechanical stops."""


class DcMotorModel:
    """The motor; at `next_ns` it has its next event, and `advance` has to be called."""

    def __init__(self, data: MotorData, position: float) -> None:
        self._data = data
        self.half = floor(2 * position)
        """The motor is between this half pulse and the next."""
        self._position, self._since_ns = position, 0
        self._speed = self._acceleration = self._target = 0.0
        self._stopped = 0
        """The direction of the mechanical stop at which the motor is; 0 for none."""
        self._crossing = 0
        """The direction in which the next event is the next half pulse; 0 for the end of an acceleration."""
        self.next_ns = NEVER_NS

    @property
    def is_high(self) -> bool:
        """The level of the sensor."""
        return self.half % 2 == 0

    def speed_at(self, now_ns: int) -> float:
        return self._speed + self._acceleration * (now_ns - self._since_ns) / S

    def position_at(self, now_ns: int) -> float:
        seconds = (now_ns - self._since_ns) / S
        position = self._position + (self._speed + self._acceleration / 2 * seconds) * seconds
        return min(max(position, self.half / 2), (self.half + 1) / 2)

    def drive(self, now_ns: int, direction: int) -> None:
        """Drive the motor in a direction, or let it coast with 0."""
        self._begin_piece(now_ns)
        self._target = direction * self._data.speed
        self._plan()

    def turn(self, now_ns: int, speed: float) -> None:
        """Give the motor a speed from outside, such as 0 for one that is blocked."""
        self._begin_piece(now_ns)
        self._speed = self._target = speed
        self._plan()

    def advance(self, now_ns: int) -> None:
        """Carry out the event of this instant."""
        self._begin_piece(now_ns)
        if not self._crossing:
            self._speed = self._target
        else:
            self._cross(self._crossing)
        self._plan()

    def _cross(self, direction: int) -> None:
        boundary = self.half + (direction > 0)
        self._position = boundary / 2
        if self._position >= self._data.high if direction > 0 else self._position <= self._data.low:
            self._stopped, self._speed = direction, 0.0
        else:
            self.half = boundary if direction > 0 else boundary - 1

    def _begin_piece(self, now_ns: int) -> None:
        self._position, self._speed = self.position_at(now_ns), self.speed_at(now_ns)
        self._since_ns = now_ns

    def _plan(self) -> None:
        """Determine the acceleration from here, and the next event."""
        if self._target * self._stopped > 0 or self._speed * self._stopped > 0:
            self._target = self._speed = 0.0
        elif self._target:
            self._stopped = 0
        change, time_s = self._target - self._speed, self._data.run_up_s if self._target else self._data.coast_s
        self._acceleration = 0.0
        if time_s and change:
            self._acceleration = self._data.speed / time_s * (1 if change > 0 else -1)
        else:
            self._speed = self._target
        ramp_s = abs(change / self._acceleration) if self._acceleration else inf
        up_s = seconds_to((self.half + 1) / 2 - self._position, self._speed, self._acceleration)
        down_s = seconds_to(self._position - self.half / 2, -self._speed, -self._acceleration)
        self._crossing = 0 if ramp_s <= min(up_s, down_s) else 1 if up_s <= down_s else -1
        seconds = min(ramp_s, up_s, down_s)
        self.next_ns = NEVER_NS if seconds == inf else self._since_ns + max(ceil(seconds * S), 1)
