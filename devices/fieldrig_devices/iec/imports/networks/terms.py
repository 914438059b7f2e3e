"""Small parts of the statements that networks become: negations, parallel branches, conditions."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.networks import functions
from fieldrig_devices.iec.imports.networks.graph import Item, Pin


def consuming(item: Item) -> list[Pin]:
    """The pins that take values, the condition of a transition among them."""
    condition = item.condition.pin if item.condition else None
    return [*item.pins(), *([condition] if condition else [])]


def position_of(item: Item) -> tree.Position:
    return tree.Position(item.line, 1)


def is_true(value: tree.Expression) -> bool:
    return isinstance(value, tree.Literal) and value.value is True


def negated(value: tree.Expression) -> tree.Expression:
    return tree.Unary("NOT", value, position=value.position)


def parallel(values: list[tree.Expression], line: int) -> tree.Expression:
    """The parallel connection of branches."""
    if any(is_true(value) for value in values):
        return next(value for value in values if is_true(value))
    return functions.balanced("OR", values, tree.Position(line, 1))


def conditional(condition: tree.Expression, body: list[tree.AnyStatement], line: int) -> tree.If:
    position = tree.Position(line, 1)
    return tree.If((tree.Branch(condition, tuple(body), position=position),), position=position)
