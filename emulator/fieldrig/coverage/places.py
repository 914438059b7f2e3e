"""The places of a program that coverage counts, and the marks that show which of them have run."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Final, NamedTuple


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
    CONDITION = "condition"
    """A condition of a decision that was TRUE, or FALSE."""
    DECIDES = "decides"
    """A condition that was TRUE, or FALSE, where it decided the decision (MC/DC)."""
    STATE = "state"
    """A value of an enumeration that a variable had."""


OF_CODE: Final = (Kind.STATEMENT, Kind.STEP, Kind.TRANSITION)
"""The kinds that lines are counted by."""
DETAILS: Final = (Kind.CONDITION, Kind.DECIDES, Kind.STATE)
"""The kinds that only a detailed report counts."""


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

    @classmethod
    def read(cls, fields: Sequence[Any]) -> "Place":
        """Return the place of these fields, as JSON has them.  ValueError or TypeError for anything else."""
        place = cls(*fields)
        return place._replace(kind=Kind(place.kind))

    @property
    def key(self) -> tuple[str, Kind, int, int, int, str]:
        return self.file, self.kind, self.line, self.column, self.of, self.what


@dataclass(slots=True)
class Marked:
    """The marks of one compiled program."""

    places: list[tuple[int, Place]] = field(default_factory=list)
    """Each place with the number of its mark.  Several share one if none of them runs without the others."""
    hits: list[int] = field(default_factory=list)
    """1 for each mark that has been passed since the program was loaded, by number; Python writes to no other kind of
    table as fast."""

    def new(self, count: int = 1) -> int:
        """Return the number of one more mark, or of the first of several."""
        self.hits += [0] * count
        return len(self.hits) - count

    def locate(self, path_of: Callable[[str], str]) -> None:
        """Replace the names of the files by their paths."""
        self.places = [(mark, place._replace(file=path_of(place.file))) for mark, place in self.places]


News = tuple[tuple[Place, bool], ...]
"""Places, and whether they have run."""
