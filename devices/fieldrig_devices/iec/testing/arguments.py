"""The arguments of a statement of a test: by position or by name, with a message behind them."""

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.testing.words import MESSAGE, Word

_OPTIONAL = frozenset({"returns"})


def matched(checker: Checker, name: str, word: Word, node: tree.Call) -> dict[str, tree.Expression] | None:
    """Return the arguments by their parameters; None after a message."""
    order = [*word.parameters, *([MESSAGE] if word.has_message else [])]
    given: dict[str, tree.Expression] = {}
    is_whole = True
    for place, argument in enumerate(node.arguments):
        parameter = word.parameter(argument.name) if argument.name else order[place] if place < len(order) else None
        if parameter is None or parameter in given or argument.value is None or argument.is_output:
            _say(checker, name, order, argument)
            is_whole = False
        else:
            given[parameter] = argument.value
    missing = [part for part in word.parameters if part not in given and part not in _OPTIONAL]
    if missing and is_whole:
        checker.context.say(node, f"{name} without {' and '.join(missing)}", f"{name}({', '.join(order)})")
    return given if is_whole and not missing else None


def _say(checker: Checker, name: str, order: list[str], argument: tree.Argument) -> None:
    what = f"{name} has no argument {argument.name}" if argument.name else f"one argument too many for {name}"
    node = argument if argument.value is None else argument.value
    checker.context.say(node, what, f"{name}({', '.join(order)})")
