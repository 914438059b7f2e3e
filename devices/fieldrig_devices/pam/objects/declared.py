"""The parameters of a declaration, as the checker has accepted them."""

from collections.abc import Sequence
from typing import Any

from fieldrig_devices.pam.language.items import Declaration
from fieldrig_devices.pam.language.tree import Number, Reference, RoutineCall, Word
from fieldrig_devices.pam.runtime.item import RoutineRef


class Declared:
    """A declaration with its values by the names of its parameters."""

    def __init__(self, declaration: Declaration) -> None:
        self.name, self.kind = declaration.name, declaration.kind
        self.parts = [Declared(part) for part in declaration.parts]
        self._values: dict[str, Sequence[Any]] = {
            parameter.name: parameter.values for parameter in declaration.parameters
        }
        self.axes = [_member(*parameter.values) for parameter in declaration.parameters if parameter.name == "AXIS"]
        """The axes of an axes set, each with its subset, which is 0 for none."""

    def __contains__(self, name: str) -> bool:
        return name in self._values

    def number(self, name: str, default: float = 0.0) -> float:
        return float(self._values[name][0].value) if name in self else default

    def integer(self, name: str, default: int = 0) -> int:
        return int(self._values[name][0].value) if name in self else default

    def pair(self, name: str) -> tuple[float, float]:
        low, high = self._values[name]
        return float(low.value), float(high.value)

    def optional(self, name: str) -> float | None:
        """Return a number, or None if it is absent or a word such as MAX, NONE or CURRENT."""
        number = self._values[name][0] if name in self else None
        return float(number.value) if isinstance(number, Number) else None

    def word(self, name: str, default: str = "") -> str:
        symbol = self._values[name][0] if name in self else None
        return symbol.name if isinstance(symbol, Word) else default

    def reference(self, name: str) -> str:
        """Return the name of an object, or nothing."""
        target = self._values[name][0] if name in self else None
        return target.name if isinstance(target, Reference) else ""

    def routine(self, name: str) -> RoutineRef:
        """Return a routine with its constants; an empty name is NONE."""
        call = self._values[name][0] if name in self else None
        if not isinstance(call, RoutineCall):
            return RoutineRef("")
        return RoutineRef(call.routine, tuple(constant(argument) for argument in call.arguments))


def _member(axis: Any, subset: Any = None) -> tuple[str, int]:
    return axis.name, int(subset.value) if subset is not None else 0


def constant(expression: Any) -> Any:
    """Return the value of a constant argument: a number, or a word as it is written."""
    if isinstance(expression, Number):
        return expression.value
    if isinstance(expression, Word):
        return expression.name
    sign = -1 if expression.operator == "-" else 1
    return sign * constant(expression.operand)
