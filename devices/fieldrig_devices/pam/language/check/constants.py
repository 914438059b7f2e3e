"""Constant arguments of functions that the manual limits: messages, the display of a node, and moves."""

from math import fmod, isfinite
from operator import add, mul, sub
from typing import Final

from fieldrig_devices.pam.language import tree
from fieldrig_devices.pam.language.check.symbols import Names

MOST_NUMBER: Final = 0xFFF
"""Largest number of a message, which has three hexadecimal digits (manual line 8561)."""
LONGEST_TEXT: Final = 40
"""Characters of the text of a message (manual line 8520)."""
DIGITS: Final = 1
"""Digits of the display of a SMART_IO (manual lines 8370 and 8391)."""
_MOST_DEEP: Final = 8
_OPERATORS: Final = {"+": add, "-": sub, "*": mul}


def constant(expression: tree.Expression, depth: int = 0) -> int | float | None:
    """Return the value of a number with its sign, or of what is computed from such; None for anything else."""
    match expression:
        case tree.Number(value=value):
            return value
        case tree.Unary(operator="+" | "-" as sign, operand=operand) if depth < _MOST_DEEP:
            inner = constant(operand, depth + 1)
            return -inner if inner is not None and sign == "-" else inner
        case tree.Binary(operator="/" | "%" as operator, left=left, right=right) if depth < _MOST_DEEP:
            first, second = constant(left, depth + 1), constant(right, depth + 1)
            return None if first is None or not second or not isfinite(first) else _divided(operator, first, second)
        case tree.Binary(operator=operator, left=left, right=right) if operator in _OPERATORS and depth < _MOST_DEEP:
            first, second = constant(left, depth + 1), constant(right, depth + 1)
            return None if first is None or second is None else _OPERATORS[operator](first, second)
    return None


def _divided(operator: str, first: int | float, second: int | float) -> int | float:
    """Return a quotient or remainder; of integers, a whole number toward zero (PAML-227, PAMS-006)."""
    quotient = first / second if operator == "/" else fmod(first, second)
    return int(quotient) if isinstance(first, int) and isinstance(second, int) else quotient


def check_constants(kind: str, statement: tree.Execute, names: Names) -> None:
    """Report constants that a function does not take."""
    if kind == "PAMDISPLAY" and len(statement.arguments) >= 2:
        _message(statement.arguments[0], statement.arguments[1], names)
    elif kind == "D7SEG_OUTPUT" and statement.function == "display":
        _display(statement.arguments, names)
    elif kind == "PMP_GENERATOR" and statement.function == "relative_move" and len(statement.arguments) == 2:
        _there_and_back(statement.arguments[0], statement.arguments[1], names)


def _message(number: tree.Expression, text: tree.Expression, names: Names) -> None:
    value = constant(number)
    if value is not None and not 0 <= value <= MOST_NUMBER:
        names.wrong(
            number.place, f"the number of the message is {value}", f"0 to #{MOST_NUMBER:X}, which is {MOST_NUMBER}"
        )
    if isinstance(text, tree.Text) and len(text.value) > LONGEST_TEXT:
        names.wrong(text.place, f"the text has {len(text.value)} characters", f"at most {LONGEST_TEXT}")


def _display(arguments: tuple[tree.Expression, ...], names: Names) -> None:
    first, last = arguments[0], arguments[-1]
    if isinstance(first, tree.Text) and len(first.value) > DIGITS:
        names.wrong(
            first.place, f"the text has {len(first.value)} characters", f"{DIGITS}, as the display of a SMART_IO"
        )
    digits = constant(last) if len(arguments) == 2 else None
    if digits is not None and digits != DIGITS:
        names.wrong(last.place, f"{digits} digits are to be shown", f"{DIGITS}, as the display of a SMART_IO has")


def _there_and_back(first: tree.Expression, second: tree.Expression, names: Names) -> None:
    ways = constant(first), constant(second)
    if ways[0] is not None and ways[1] is not None and ways[0] * ways[1] > 0:
        hint = "They must be in opposite directions (manual line 6132); the generator ignores the order."
        names.note(second.place, "both displacements have one direction", hint)
