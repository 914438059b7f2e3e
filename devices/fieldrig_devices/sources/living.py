"""The values of one device that live by themselves: brought up to date at each read, or at each change."""

import heapq
from collections.abc import Callable, Iterable
from typing import NamedTuple, Protocol

from fieldrig.clock import NEVER_NS, Alarm, Clock
from fieldrig_devices.sources.shapes import Number, Source


class Chance(Protocol):
    """The part of `random.Random` that sources use; a rig gives each device one by the rig's seed."""

    def getrandbits(self, bits: int, /) -> int: ...


def seed_from(chance: Chance | None) -> str:
    """Return what the names of a device's sources begin with, so that the seed of the rig changes their ways."""
    return "" if chance is None else f"{chance.getrandbits(64)}/"


class Living(NamedTuple):
    """A source, and what takes its values."""

    source: Source
    put: Callable[[Number], None]


class LivingValues:
    """All living values of a device.

    `refresh` before each read is enough for what is only read: nothing is computed between reads.  `follow` is for
    what others wait for, such as wires and event-driven PDOs: each change is put at its instant.
    """

    def __init__(self, clock: Clock, values: Iterable[Living]) -> None:
        self._clock, self._values = clock, tuple(values)
        self._alarm = Alarm(clock)
        self._begun_ns = clock.now_ns()
        self._due: list[tuple[int, int]] = []
        """A heap: the age of the next change of each value, and the position of the value."""

    def __bool__(self) -> bool:
        return bool(self._values)

    def start(self) -> None:
        """Begin at age 0: the device has been switched on."""
        self._begun_ns = self._clock.now_ns()
        self._due = [(0, place) for place in range(len(self._values))]
        self.refresh()

    def refresh(self) -> None:
        """Put the present value of each source that has changed."""
        age_ns, due = self._clock.now_ns() - self._begun_ns, self._due
        while due and due[0][0] <= age_ns:
            place = due[0][1]
            source, put = self._values[place]
            put(source.at(age_ns))
            next_ns = source.next_ns(age_ns)
            if next_ns < NEVER_NS:
                heapq.heapreplace(due, (next_ns, place))
            else:
                heapq.heappop(due)

    def follow(self) -> None:
        """Put each value at the instant of its change from now on."""
        self.refresh()
        self._alarm.at(self._begun_ns + self._due[0][0] if self._due else None, self.follow)

    def stop(self) -> None:
        """End what `follow` has begun: the device is switched off."""
        self._alarm.stop()
