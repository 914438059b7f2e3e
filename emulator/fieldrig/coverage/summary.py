"""The sum of what has run of programs: by POU, by file and by line."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from fieldrig.coverage.places import DETAILS, OF_CODE, Kind, News, Place


class Count(NamedTuple):
    run: int
    all: int

    @property
    def per_cent(self) -> float:
        """100 where there is nothing to run."""
        return 100.0 * self.run / self.all if self.all else 100.0


@dataclass
class Part:
    """The places of one POU, of one file or of a whole project, each with whether it has run."""

    name: str
    places: list[tuple[Place, bool]] = field(default_factory=list)

    def count(self, *kinds: Kind) -> Count:
        """Count the places of these kinds; without any, all places."""
        chosen = [has_run for place, has_run in self.places if not kinds or place.kind in kinds]
        return Count(sum(chosen), len(chosen))

    def count_of_case(self) -> Count:
        """Count the branches of CASE, without ELSE."""
        chosen = [has_run for place, has_run in self.places if place.kind is Kind.BRANCH and place.what[:5] == "CASE "]
        return Count(sum(chosen), len(chosen))

    def lines(self) -> dict[int, bool]:
        """Return the lines with a statement, a step or a transition; true where one of them has run."""
        found: dict[int, bool] = {}
        for place, has_run in self.places:
            if place.kind in OF_CODE:
                found[place.line] = found.get(place.line, False) or has_run
        return dict(sorted(found.items()))

    def branches(self) -> dict[int, list[tuple[Place, bool]]]:
        """Return the branches of each choice, by the lines of the choices."""
        found = defaultdict[int, list[tuple[Place, bool]]](list)
        for place, has_run in self.places:
            if place.kind is Kind.BRANCH:
                found[place.of].append((place, has_run))
        return dict(sorted(found.items()))

    def has_reached(self, branch: Place) -> bool:
        """True if the choice of a branch has run."""
        return self._run.get((branch.of, branch.column), False)

    @cached_property
    def _run(self) -> dict[tuple[int, int], bool]:
        statements = [(place, has_run) for place, has_run in self.places if place.kind is Kind.STATEMENT]
        return {(place.line, place.column): has_run for place, has_run in statements}

    def missed_lines(self) -> list[int]:
        """Return the lines on which something has not run that is no branch."""
        return sorted({place.line for place, has_run in self.places if not has_run and place.kind in OF_CODE})

    def missed_branches(self) -> list[Place]:
        """Return the branches that were not taken though their choice has run, and whose own lines do not show it."""
        shown = set(self.missed_lines())
        return [
            place
            for place, has_run in self.places
            if place.kind is Kind.BRANCH
            and not has_run
            and self.has_reached(place)
            and (place.line == place.of or place.line not in shown)
        ]

    def missed_details(self) -> list[Place]:
        """Return the conditions that were not TRUE or not FALSE, or did not decide, and the states that were not.

        Those of a decision that has not run are left out, and so is a condition that did not decide where it was not
        even TRUE, or FALSE.
        """
        missed = {place: None for place, has_run in self.places if not has_run and place.kind in DETAILS}
        lines = self.lines()
        return [
            place
            for place in missed
            if (place.kind is Kind.STATE or lines.get(place.of, True))
            and (place.kind is not Kind.DECIDES or place._replace(kind=Kind.CONDITION) not in missed)
        ]


class Coverage:
    """The sum over all programs, processes and runs that were added."""

    def __init__(self, news: News = ()) -> None:
        self._places: dict[object, Place] = {}
        self._has_run: dict[object, bool] = {}
        self._paths: dict[str, str] = {}
        """The whole paths of files, as a rig and a test may name the same one differently."""
        self.add(news)

    def add(self, news: News) -> None:
        for place, has_run in news:
            if place.file not in self._paths:
                self._paths[place.file] = str(Path(place.file).resolve())
            place = place._replace(file=self._paths[place.file])
            self._places.setdefault(place.key, place)
            self._has_run[place.key] = self._has_run.get(place.key, False) or has_run

    @property
    def news(self) -> News:
        """All places, and whether they have run."""
        return tuple((place, self._has_run[key]) for key, place in self._places.items())

    @property
    def total(self) -> Part:
        return Part("total", list(self.news))

    def files(self) -> list[Part]:
        """Return the files, with their paths from the working folder, in the order of these."""
        parts = _divided(self.total, lambda place: place.file)
        return [Part(_from_here(part.name), part.places) for part in sorted(parts, key=lambda part: part.name)]


def pous(part: Part) -> list[Part]:
    """Return the POUs of a file, in the order of the text."""
    return _divided(part, lambda place: place.pou)


def ranges(lines: Sequence[int], known: Iterable[int]) -> str:
    """Return lines as ranges, such as `3, 7-9`.  Lines between that are not `known` do not divide a range."""
    order = {line: number for number, line in enumerate(sorted({*known, *lines}))}
    parts: list[list[int]] = []
    for line in lines:
        if parts and order[line] == order[parts[-1][-1]] + 1:
            parts[-1].append(line)
        else:
            parts.append([line])
    return ", ".join(f"{part[0]}-{part[-1]}" if len(part) > 1 else f"{part[0]}" for part in parts)


def _divided(part: Part, name_of: Callable[[Place], str]) -> list[Part]:
    parts: dict[str, Part] = {}
    for place, has_run in sorted(part.places, key=lambda one: (one[0].file, one[0].line, one[0].column)):
        name = name_of(place)
        parts.setdefault(name, Part(name)).places.append((place, has_run))
    return list(parts.values())


def _from_here(file: str) -> str:
    """Return a path from the working folder, if it is inside."""
    path, here = Path(file), Path.cwd()
    return path.relative_to(here).as_posix() if path.is_relative_to(here) else str(path)
