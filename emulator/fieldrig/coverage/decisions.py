"""The conditions of a decision, and which of them decide it: condition coverage and MC/DC.

A decision joins conditions by AND, OR and NOT.  Generated code marks the combination of values with which it is
evaluated, so what has been seen follows from the marks, also when they come from several runs.

Source: DO-178C's MC/DC in the form "masking", Certification Authorities Software Team, position paper CAST-6.  A
condition has to be seen TRUE and FALSE where it decides: where the other value of it alone would turn the decision.
A condition that is not evaluated, behind AND_THEN or OR_ELSE, may have either value.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

from fieldrig.coverage.places import Kind

FEWEST: Final = 2
"""Conditions of a decision; with one condition, the branches show as much."""
MOST: Final = 6
"""Conditions of a decision whose combinations are marked: 64 marks."""


@dataclass(frozen=True, slots=True)
class Not:
    of: "Formula"


@dataclass(frozen=True, slots=True)
class Join:
    """AND or OR of two parts; with `is_lazy` the right one is evaluated only if the left one leaves it open."""

    is_and: bool
    left: "Formula"
    right: "Formula"
    is_lazy: bool = False


Formula = int | Not | Join
"""A decision; a number is a condition, from 0 and from left to right."""


def conditions_in(formula: Formula) -> int:
    """Return the number of conditions."""
    match formula:
        case Not(of):
            return conditions_in(of)
        case Join(_, left, right):
            return conditions_in(left) + conditions_in(right)
    return 1


def value_of(formula: Formula, values: Sequence[bool], evaluated: set[int]) -> bool:
    """Return the value of a decision, and add the conditions that are evaluated."""
    match formula:
        case Not(of):
            return not value_of(of, values, evaluated)
        case Join(is_and, left, right, is_lazy):
            first = value_of(left, values, evaluated)
            if is_lazy and first is not is_and:
                return first
            second = value_of(right, values, evaluated)
            return (first and second) if is_and else (first or second)
        case int():
            evaluated.add(formula)
            return values[formula]


def seen_with(formula: Formula, combination: int) -> Iterator[tuple[Kind, int, bool]]:
    """Yield what a combination shows: conditions with their values, and those that decide with these.

    Bit N of `combination` is the value of condition N.
    """
    count = conditions_in(formula)
    values = [bool(combination >> number & 1) for number in range(count)]
    evaluated = set[int]()
    value = value_of(formula, values, evaluated)
    for number in sorted(evaluated):
        yield Kind.CONDITION, number, values[number]
        if _decides(formula, number, value, values, evaluated):
            yield Kind.DECIDES, number, values[number]


def _decides(formula: Formula, number: int, value: bool, values: list[bool], evaluated: set[int]) -> bool:
    """True if the other value of a condition could turn the decision."""
    free = [one for one in range(len(values)) if one not in evaluated]
    for filling in product((False, True), repeat=len(free)):
        other = list(values)
        other[number] = not other[number]
        for one, filled in zip(free, filling, strict=True):
            other[one] = filled
        if value_of(formula, other, set()) is not value:
            return True
    return False
