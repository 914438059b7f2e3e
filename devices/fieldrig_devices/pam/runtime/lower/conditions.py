"""The conditions of a decision, for the marks of coverage: with flags, `+` is OR, `*` is AND, and `!` is NOT."""

from dataclasses import dataclass, field

from fieldrig.coverage.decisions import Formula, Join, Not
from fieldrig_devices.pam.language import tree
from fieldrig_devices.pam.language.tree import Expression
from fieldrig_devices.pam.runtime.lower.operands import Emitter, Operand, OperandOf

LONGEST = 40
"""Longest text of a condition in a report."""


@dataclass
class Decision:
    """A decision that is being lowered, with its conditions from left to right."""

    operand_of: OperandOf
    emitter: Emitter
    values: list[str] = field(default_factory=list)
    """Variables, each 0 or 1."""
    texts: list[str] = field(default_factory=list)

    def lower(self, expression: Expression) -> tuple[Operand, Formula]:
        """Return the value of a decision as a flag, and its form."""
        match expression:
            case tree.Unary(operator="!", operand=inner):
                operand, formula = self.lower(inner)
                return Operand(f"(not {operand.text})", "flag"), Not(formula)
            case tree.Binary(operator="+" | "*" as operator, left=left, right=right) if self._is_logical(left, right):
                first, before = self.lower(left)
                second, behind = self.lower(right)
                word = "and" if operator == "*" else "or"
                return Operand(f"({first.text} {word} {second.text})", "flag"), Join(operator == "*", before, behind)
        value = self.emitter.flag(self.operand_of(expression, self.emitter))
        self.values.append(self.emitter.new(f"1 if {value.text} else 0"))
        self.texts.append(text(expression))
        return Operand(self.values[-1], "flag"), len(self.values) - 1

    def _is_logical(self, *sides: Expression) -> bool:
        """True for flags; numbers are added and multiplied."""
        return all(self.operand_of(side, Emitter()).type == "flag" for side in sides)


def conditions_at_most(expression: Expression, most: int) -> bool:
    """True if an expression has so few parts that it cannot have more conditions."""
    waiting, found = [expression], 0
    while waiting and found <= most:
        match waiting.pop():
            case tree.Unary(operator="!", operand=inner):
                waiting.append(inner)
            case tree.Binary(operator="+" | "*", left=left, right=right):
                waiting += (left, right)
            case _:
                found += 1
    return found <= most


def text(expression: Expression) -> str:
    """Return a condition as it could be written; `...` for what is long."""
    shown = _text(expression)
    return shown if len(shown) <= LONGEST else "..."


def _text(expression: Expression) -> str:
    match expression:
        case tree.Number(value=value, spelling=spelling):
            return spelling or str(value)
        case tree.Word(name=name):
            return name
        case tree.Reference(name=name, index=index):
            return name if index is None else f"{name}[{index}]"
        case tree.ParameterOf(subject=subject, parameter=parameter):
            return f"{_text(subject)}:{parameter}"
        case tree.Inquiry(subject=inner, function=function):
            return f"{_text(inner)} ? {function}"
        case tree.Binary(operator=operator, left=left, right=right):
            return f"{text(left)} {operator} {text(right)}"
        case tree.Unary(operator=operator, operand=inner):
            return f"{operator}{text(inner)}"
        case tree.Reduction(operand=inner, index=index):
            return f"({text(inner)})[{index}]"
    return "..."
