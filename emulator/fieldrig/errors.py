"""The errors outside our own code, each with its remedy.

RigError              anything that a user can fix; printed without a traceback
├── ConfigError       wrong configuration, with every mistake found
├── UsageError        a command was called with a wrong request, or with a file of the wrong kind
├── ArgumentError     a call from Python has a wrong argument; a TypeError and a ValueError as well
├── UnmetError        a condition did not hold in time
├── BusError          a port, a path or a network device that is not available
├── EndlessError      devices answer each other without end at one instant of virtual time
├── RefusedError      a device outside, such as an encoder at a serial port, refuses what a command asks for
└── ControlError      no rig answers, or it refuses
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass


class RigError(Exception):
    """Something outside our code is wrong; `remedy` says what to do."""

    def __init__(self, what: str, remedy: str = "") -> None:
        super().__init__(f"{what}\n  {remedy}" if remedy else what)
        self.what = what
        self.remedy = remedy


@dataclass(frozen=True, slots=True)
class Mistake:
    """One mistake in a configuration: where it is, what is wrong, and what was expected."""

    file: str
    line: int | None
    key: str
    what: str
    remedy: str = ""
    column: int | None = None
    """The column of a mistake in a program."""

    def __str__(self) -> str:
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part is not None)
        head = ": ".join(part for part in (place, self.key, self.what) if part)
        return f"{head}\n    {self.remedy}" if self.remedy else head


class ConfigError(RigError):
    """Wrong configuration, with every mistake found."""

    def __init__(self, mistakes: Sequence[Mistake]) -> None:
        super().__init__("\n".join(str(mistake) for mistake in mistakes))
        self.mistakes = list(mistakes)

    def __reduce__(self) -> "tuple[type[ConfigError], tuple[list[Mistake]]]":
        """Cross a pipe with the mistakes; their text alone makes no error."""
        return type(self), (self.mistakes,)


class UsageError(RigError):
    """A command was called with a wrong request, or with a file of the wrong kind."""


class ArgumentError(RigError, TypeError, ValueError):
    """A call from Python has an argument that it cannot take.  Python's own raise TypeError or ValueError then."""


class UnmetError(RigError):
    """A condition did not hold in time; `remedy` has the values that it saw."""


class BusError(RigError):
    """A bus or one of its ports cannot be opened."""


class EndlessError(RigError):
    """Devices answer each other without end, and no time passes."""


class GoneError(RigError):
    """The process of a branch has ended from outside, such as by a system without memory."""


class RefusedError(RigError):
    """A device that a command talks to refuses the request."""


class ControlError(RigError):
    """No rig answers at the control endpoint, or it refuses the request."""


@contextmanager
def refusals(place: str) -> Iterator[None]:
    """Turn a ValueError into a ControlError of `place`.

    The first line of its text is the problem, the rest is the remedy.
    """
    try:
        yield
    except ValueError as cause:
        what, _, remedy = str(cause).partition("\n")
        raise ControlError(f"{place}: {what}", remedy) from cause
