"""The instructions that the card still has to send to its terminal, in order.

A program that shows the same text in a loop issues instructions faster than the bus can ever carry them.  So a TERM
replaces a waiting one for the same place, and one that clears the screen replaces all of those; the final screen is the
same.  Messages and lines to print are never replaced.
"""

from dataclasses import dataclass
from itertools import count
from typing import Final

from fieldrig_devices.arp.runtime.card import Shown
from fieldrig_devices.arp.terminal.messages import COUNT
from fieldrig_devices.arp.terminal.screen import Place

MAX_WAITING: Final = COUNT + 100
"""Maximum number of waiting jobs: a program that loads all messages, and a reserve."""


@dataclass(frozen=True, slots=True)
class Store:
    """An MSG instruction."""

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
    """Value of the variable when TERM was executed."""


@dataclass(frozen=True, slots=True)
class Line:
    """A PRINT instruction."""

    message: int
    raw: int | None


Job = Store | Clear | Erase | Show | Line


class Jobs:
    def __init__(self) -> None:
        self._waiting: dict[Place | int, Job] = {}
        self._numbers = count()

    def put(self, job: Job) -> bool:
        """Add a job.  False if there was no room."""
        if isinstance(job, Clear):
            self._waiting = {
                key: waiting for key, waiting in self._waiting.items() if isinstance(waiting, Store | Line)
            }
        key = job.place if isinstance(job, Erase | Show) else next(self._numbers)
        self._waiting.pop(key, None)
        if len(self._waiting) >= MAX_WAITING:
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
