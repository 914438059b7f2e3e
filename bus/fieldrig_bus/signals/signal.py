"""The present value of a wire, and a value that moves steadily."""

from dataclasses import dataclass

from fieldrig.clock import S


@dataclass(frozen=True, slots=True)
class Signal:
    """The present value of one wire: digital as bool, analog as a number in `unit` (SI or %, "" for a digital one)."""

    name: str
    value: bool | int | float
    unit: str = ""

    @property
    def is_moving(self) -> bool:
        """True if `at` returns different values at different instants."""
        return False

    def at(self, now_ns: int) -> bool | int | float:
        """The value of the wire at `now_ns`, which is the same for every device that has received this signal."""
        return self.value

    def speed_at(self, now_ns: int) -> float:
        """The speed in units per second at `now_ns`."""
        return 0.0


@dataclass(frozen=True, slots=True)
class Motion(Signal):
    """A signal that moves by itself until the next one is published: `value` is its position at `time_ns`.

    A receiver that does not handle motions treats it as a signal with that value.
    """

    time_ns: int = 0
    speed: float = 0.0
    """Speed in units per second at `time_ns`."""
    acceleration: float = 0.0
    """Acceleration in units per second squared."""

    @property
    def is_moving(self) -> bool:
        return bool(self.speed or self.acceleration)

    def at(self, now_ns: int) -> float:
        seconds = (now_ns - self.time_ns) / S
        return self.value + (self.speed + self.acceleration / 2 * seconds) * seconds

    def speed_at(self, now_ns: int) -> float:
        return self.speed + self.acceleration * (now_ns - self.time_ns) / S
