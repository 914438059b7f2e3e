"""The places of a program that coverage counts, and the marks that show which of them have run."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple


class Kind(StrEnum):
    """The kinds of places."""

    STATEMENT = "statement"
    BRANCH = "branch"
    """One way out of a choice, also the one that the source does not write, such as an ELSE that is missing; or the
    body of a loop, and its being skipped."""
    STEP = "step"
    """A step of a chart that was active."""
    TRANSITION = "transition"
    """A transition of a chart that fired."""


class Place(NamedTuple):
    """One place.  A place that is compiled twice, such as a method that is inherited, is the same one."""

    file: str
    pou: str
    """The name of the program, function block, function, method or action."""
    kind: Kind
    line: int
    """Its number from 1; that of ELSIF or of the labels of a CASE for their branches, and of the choice for others."""
    column: int
    of: int = 0
    """The line of the choice or loop of a branch; otherwise 0."""
    what: str = ""
    """The name of a branch, such as `ELSE` or `CASE 2`, of a step, or of a transition."""

    @property
    def key(self) -> tuple[str, Kind, int, int, int, str]:
        return self.file, self.kind, self.line, self.column, self.of, self.what


@dataclass(slots=True)
class Marked:
    """The marks of one compiled program."""

    places: list[tuple[int, Place]] = field(default_factory=list)
    """Each place with the number of its mark.  Several share one if none of them runs without the others."""
    hits: bytearray = field(default_factory=bytearray)
    """1 for each mark that has been passed since the program was compiled, by number."""
