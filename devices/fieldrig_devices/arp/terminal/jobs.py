"""What the card still has to tell its terminal, in the order of the instructions.

Instructions come faster than the bus carries them, also for ever, from a program that shows the same in a loop.  So a
TERM goes in place of what waits for the same place, and one that clears in place of all of those: what is on the
screen in the end is the same.  Messages and lines to print are never left out for others.
"""

from dataclasses import dataclass
from itertools import count
from typing import Final

from fieldrig_devices.arp.runtime.card import Shown
from fieldrig_devices.arp.terminal.messages import COUNT
from fieldrig_devices.arp.terminal.screen import Place

MOST: Final = COUNT + 100
"""A program that loads all messages, and then some."""


@dataclass(frozen=True, slots=True)
class Store:
    """MSG."""

    number: int
    text: str


@dataclass(frozen=True, slots=True)
class Clear:
    pass


@dataclass(frozen=True, slots=True)
class Erase:
    place: Place


@dataclass(frozen=True, slots=True)
class Show:
    place: Place
    shown: Shown
    raw: int | None = None
    """What the variable was when TERM was executed."""


@dataclass(frozen=True, slots=True)
class Line:
    """PRINT."""

    message: int
    raw: int | None


Job = Store | Clear | Erase | Show | Line


class Jobs:
    def __init__(self) -> None:
        self._waiting: dict[Place | int, Job] = {}
        self._numbers = count()

    def put(self, job: Job) -> bool:
        """Whether there was room."""
        if isinstance(job, Clear):
            self._waiting = {key: one for key, one in self._waiting.items() if isinstance(one, Store | Line)}
        key = job.place if isinstance(job, Erase | Show) else next(self._numbers)
        self._waiting.pop(key, None)
        if len(self._waiting) >= MOST:
            return False
        self._waiting[key] = job
        return True

    def first(self) -> Job | None:
        return next(iter(self._waiting.values()), None)

    def drop_first(self) -> None:
        del self._waiting[next(iter(self._waiting))]

    def take_all(self) -> list[Job]:
        jobs, self._waiting = list(self._waiting.values()), {}
        return jobs
