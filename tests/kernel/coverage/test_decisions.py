"""Conditions and MC/DC of decisions, by hand and against a definition that looks at all pairs."""

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.coverage.decisions import Formula, Join, Not, conditions_in, seen_with, value_of
from fieldrig.coverage.places import Kind

BOTH, EITHER = Join(True, 0, 1), Join(False, 0, 1)
LAZY = Join(True, 0, 1, is_lazy=True)
HAND = [
    # decision, combination, conditions, those that decide
    (BOTH, 0b11, {(0, True), (1, True)}, {(0, True), (1, True)}),
    (BOTH, 0b10, {(0, False), (1, True)}, {(0, False)}),
    (BOTH, 0b00, {(0, False), (1, False)}, set()),
    (EITHER, 0b00, {(0, False), (1, False)}, {(0, False), (1, False)}),
    (EITHER, 0b01, {(0, True), (1, False)}, {(0, True)}),
    (EITHER, 0b11, {(0, True), (1, True)}, set()),
    (LAZY, 0b00, {(0, False)}, {(0, False)}),
    (LAZY, 0b01, {(0, True), (1, False)}, {(1, False)}),
    (Join(True, Not(0), 1), 0b10, {(0, False), (1, True)}, {(0, False), (1, True)}),
]


@pytest.mark.parametrize(("formula", "combination", "conditions", "deciding"), HAND)
def test_a_combination_shows(
    formula: Formula, combination: int, conditions: set[tuple[int, bool]], deciding: set[tuple[int, bool]]
) -> None:
    seen = list(seen_with(formula, combination))
    assert {(number, value) for kind, number, value in seen if kind is Kind.CONDITION} == conditions
    assert {(number, value) for kind, number, value in seen if kind is Kind.DECIDES} == deciding


def numbered(formula: object, first: int = 0) -> Formula:
    """Give the conditions of a decision their numbers, from left to right."""
    match formula:
        case Not(of):
            return Not(numbered(of, first))
        case Join(is_and, left, right, is_lazy):
            before = numbered(left, first)
            return Join(is_and, before, numbered(right, first + conditions_in(before)), is_lazy)
    return first


FORMULAS = st.recursive(
    st.just(0),
    lambda inner: st.builds(Not, inner) | st.builds(Join, st.booleans(), inner, inner, st.booleans()),
    max_leaves=5,
).map(numbered)


@given(FORMULAS)
def test_what_decides_turns_the_decision_by_itself(formula: Formula) -> None:
    count = conditions_in(formula)
    for values in product((False, True), repeat=count):
        combination = sum(value << number for number, value in enumerate(values))
        evaluated = set[int]()
        value = value_of(formula, values, evaluated)
        rows = list(seen_with(formula, combination))
        assert {number for kind, number, _ in rows if kind is Kind.CONDITION} == evaluated
        deciding = {number for kind, number, _ in rows if kind is Kind.DECIDES}
        # Another combination that differs in one evaluated condition, and in any that are not evaluated.
        turned = {
            number
            for number in evaluated
            for other in product((False, True), repeat=count)
            if all((other[one] != values[one]) == (one == number) for one in evaluated)
            and value_of(formula, other, set()) != value
        }
        assert deciding == turned
