"""Marks in one body of generated code that show what of it has run.

There is one at the head of each suite of statements, and one where a suite may have been left in between; a mark stands
for all statements up to the next one.  A statement behind one that faults counts as run if they share a mark.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final

from fieldrig.coverage.decisions import Formula, seen_with
from fieldrig.coverage.places import Place

HIT: Final = "hit"
"""The name of the marks in generated code, in a program whose coverage is wanted: 1 for each that has run."""


def hit(mark: int) -> str:
    """Return the line of generated code that passes a mark."""
    return f"{HIT}[{mark}] = 1"


def combination(first: int, values: Sequence[str]) -> str:
    """Return the line of generated code that marks a combination of conditions, by variables that are 0 or 1."""
    terms = [str(first), *(f"{1 << number} * {value}" if number else value for number, value in enumerate(values))]
    return f"{HIT}[{' + '.join(terms)}] = 1"


class SuiteMarks:
    """The marks of one body; none if it is not covered."""

    def __init__(self, mark: Callable[[], int], *, is_on: bool) -> None:
        """`mark` adds one to the code, and returns its number."""
        self._mark, self.is_on = mark, is_on
        self.places: list[tuple[int, Place]] = []
        self._present: int | None = None
        """The mark that stands for the next statement; None if that needs a new one."""

    @contextmanager
    def suite(self) -> Iterator[None]:
        """Begin a suite of statements; behind it the one around it goes on."""
        before, self._present = self._present, None
        yield
        self._present = before

    def add(self, place: Place) -> None:
        """Add a place, which has run if what comes next in the code has."""
        if not self.is_on:
            return
        if self._present is None:
            self._present = self._mark()
        self.places.append((self._present, place))

    def alone(self, mark: int, place: Place) -> None:
        """Add a place with a mark of its own, which something else than the next code passes."""
        self.places.append((mark, place))

    def decision(self, formula: Formula, first: int, texts: Sequence[str], at: Place) -> None:
        """Add the places of the conditions of a decision, whose combinations have the marks from `first` on.

        `texts` are the conditions as the source has them, and `at` is the place of the decision.
        """
        known = dict.fromkeys(texts, 0)
        names = []
        for text in texts:
            known[text] += 1
            names.append(text if known[text] == 1 else f"{text} ({known[text]})")
        for combination in range(1 << len(texts)):
            for kind, number, value in seen_with(formula, combination):
                what = f"{names[number]} {'TRUE' if value else 'FALSE'}"
                self.alone(first + combination, at._replace(kind=kind, of=at.line, what=what))

    def leave(self) -> None:
        """The next statement may not run, or run without those before it."""
        self._present = None
