"""What can be wrong outside our own code, each with its remedy.

RigError              anything a user can mend; printed without a traceback
├── ConfigError       wrong configuration, with every mistake found
├── UsageError        a command was asked for what can't be, or given a file that isn't what it should be
├── BusError          a port, a path, a network device that can't be had
├── RefusedError      a device outside, such as an encoder at a serial port, refuses what a command asks for
└── ControlError      no rig answers, or it refuses
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass


class RigError(Exception):
    """Something outside our code is wrong; `remedy` says what to do next."""

    def __init__(self, what: str, remedy: str = "") -> None:
        super().__init__(f"{what}\n  {remedy}" if remedy else what)
        self.what = what
        self.remedy = remedy


@dataclass(frozen=True, slots=True)
class Mistake:
    """One thing that is wrong in a configuration, and what would be right."""

    file: str
    line: int | None
    key: str
    what: str
    remedy: str = ""

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}" if self.line is not None else self.file
        head = ": ".join(part for part in (place, self.key, self.what) if part)
        return f"{head}\n    {self.remedy}" if self.remedy else head


class ConfigError(RigError):
    """Wrong configuration, with every mistake found."""

    def __init__(self, mistakes: Sequence[Mistake]) -> None:
        super().__init__("\n".join(str(mistake) for mistake in mistakes))
        self.mistakes = list(mistakes)


class UsageError(RigError):
    """A command was asked for what can't be, or given a file that isn't what it should be."""


class BusError(RigError):
    """A bus or one of its ports can't be opened."""


class RefusedError(RigError):
    """A device that a command talks to refuses the request."""


class ControlError(RigError):
    """No rig answers at the control endpoint, or it refuses what it was asked."""


@contextmanager
def refusals(place: str) -> Iterator[None]:
    """A ValueError as a ControlError of `place`: its first line is what is wrong, the others are the remedy."""
    try:
        yield
    except ValueError as cause:
        what, _, remedy = str(cause).partition("\n")
        raise ControlError(f"{place}: {what}", remedy) from cause
