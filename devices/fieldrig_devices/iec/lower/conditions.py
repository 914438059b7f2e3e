"""Marks of the combinations of values with which a decision is evaluated."""

from typing import Final

from fieldrig.coverage.decisions import FEWEST, MOST, Formula, Join, Not, conditions_in
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.texts import text
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import Binary, Expression, Operator, Unary

_JOINS: Final = {
    Operator.AND: Join(True, 0, 0),
    Operator.OR: Join(False, 0, 0),
    Operator.AND_THEN: Join(True, 0, 0, is_lazy=True),
    Operator.OR_ELSE: Join(False, 0, 0, is_lazy=True),
}
_WORDS: Final = frozenset({"AND", "&", "OR", "AND_THEN", "OR_ELSE"})


def is_joint(expression: Expression) -> bool:
    """True for AND, OR and NOT of conditions."""
    match expression:
        case Binary(operator, _, _, Elementary.BOOL):
            return operator in _JOINS
        case Unary(Operator.NOT, _, Elementary.BOOL):
            return True
    return False


def formula_of(expression: Expression, first: int = 0) -> Formula:
    """Return a decision with its conditions by number, from `first` on."""
    match expression:
        case Binary(operator, left, right, Elementary.BOOL) if operator in _JOINS:
            before = formula_of(left, first)
            join = _JOINS[operator]
            return Join(join.is_and, before, formula_of(right, first + conditions_in(before)), join.is_lazy)
        case Unary(Operator.NOT, operand, Elementary.BOOL):
            return Not(formula_of(operand, first))
    return first


def is_decision(expression: Expression) -> bool:
    """True if it has as many conditions as marks are made for; a deep expression has too many."""
    return FEWEST <= _count(expression) <= MOST


def _count(expression: Expression) -> int:
    """Return the number of conditions, or a number above MOST; an expression may have thousands of terms."""
    waiting, found = [expression], 0
    while waiting and found + len(waiting) <= MOST:
        match one := waiting.pop():
            case Binary(_, left, right) if is_joint(one):
                waiting += (left, right)
            case Unary(_, operand) if is_joint(one):
                waiting.append(operand)
            case _:
                found += 1
    return found + len(waiting)


def texts_of(node: tree.Expression, count: int) -> list[str]:
    """Return the conditions of a decision as the source has them; by numbers if the source has another form."""
    found = [text(one) for one in _leaves(node)] if _fits(node) else []
    return found if len(found) == count else [f"condition {number}" for number in range(1, count + 1)]


def _fits(node: tree.Expression) -> bool:
    depth, one = 0, node
    while isinstance(one, tree.Binary) and depth <= MOST:
        depth, one = depth + 1, one.left
    return depth <= MOST


def _leaves(node: tree.Expression) -> list[tree.Expression]:
    match node:
        case tree.Binary(operator=operator, left=left, right=right) if operator.upper() in _WORDS:
            return [*_leaves(left), *_leaves(right)]
        case tree.Unary(operator=operator, operand=operand) if operator.upper() == "NOT":
            return _leaves(operand)
    return [node]
