"""A condition on a point at which a fault begins, such as `tank/level > 1.5` or `axis/6041:00 & 0x6f == 0x27`."""

import operator
import re
from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any, Final, NamedTuple

from fieldrig.config.yaml_source import read
from fieldrig.errors import ControlError
from fieldrig.text.nearest import closest

Value = bool | int | float | str
OPERATORS: Final[dict[str, Callable[[Any, Any], bool]]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<=": operator.le,
    ">=": operator.ge,
    "<": operator.lt,
    ">": operator.gt,
}
LONGEST: Final = 1_000
FORM: Final = "expected DEVICE/POINT, or DEVICE/POINT with ==, !=, <, >, <= or >= and a value"
_PARTS: Final = re.compile(
    r"\s*(?P<device>[^/\s]+)/(?P<key>\S+?)\s*(&\s*(?P<mask>\S+?)\s*)?((?P<operator>[=!<>]=|[<>])\s*(?P<value>.+?)\s*)?"
)


class Condition(NamedTuple):
    """A condition; it is met while the point has such a value."""

    device: str
    key: str
    mask: int | None
    operator: str
    value: Value

    @property
    def point(self) -> str:
        return f"{self.device}/{self.key}"

    def is_met(self, value: Value) -> bool:
        """Return whether a value of the point meets the condition; one of another type never does."""
        if self.mask is not None:
            if not isinstance(value, int):
                return False
            value = value & self.mask
        if isinstance(value, str) is not isinstance(self.value, str):
            return False
        return OPERATORS[self.operator](value, self.value)


def condition_of(text: str) -> Condition:
    """Return the condition that a text states.  ValueError, saying what was expected, for any other text."""
    found = _PARTS.fullmatch(text) if len(text) <= LONGEST else None
    if found is None:
        raise ValueError(f"{text[:80]!r} is no condition\n{FORM}")
    mask = None if found["mask"] is None else _value(found["mask"])
    if mask is not None and type(mask) is not int:
        raise ValueError(f"{found['mask']!r} is no mask\nexpected a whole number, such as 0x6f")
    if found["operator"] is None:
        return Condition(found["device"], found["key"], mask, "!=", 0)
    return Condition(found["device"], found["key"], mask, found["operator"], _value(found["value"]))


def never(condition: Condition, present: Value, states: Sequence[str]) -> str | None:
    """Return why a condition can never be met, and in the next line what would be right; None if it can.

    `present` is a value of its point, and `states` are all values that the point has; none for a point with others.
    """
    expected = condition.value
    if states and expected not in states:
        return f"{condition.point} is never {expected!r}\n{closest(expected, states)}"
    if isinstance(present, str) is not isinstance(expected, str):
        sort = "a text" if isinstance(present, str) else "a number"
        return f"{condition.point} is never {expected!r}\nexpected {sort}, such as {present!r}"
    if isinstance(present, bool) and not any(condition.is_met(truth) for truth in (False, True)):
        return f"{condition.point} is never {condition.operator} {expected!r}\nexpected true or false"
    return None


def check_possible(condition: Condition, present: Value, states: Sequence[str]) -> None:
    """ControlError, for what adds a fault while a rig runs, if its condition can never be met."""
    wrong = never(condition, present, states)
    if wrong is not None:
        what, _, remedy = wrong.partition("\n")
        raise ControlError(f"when: {what}", remedy)


def _value(text: str) -> Any:
    source = read(text, "")
    value = source.data
    if source.mistakes or not isinstance(value, bool | int | float | str):
        raise ValueError(f"{text!r} is no value of a point\nexpected a number, true, false or a text")
    if isinstance(value, float) and not isfinite(value):
        raise ValueError(f"{text!r} is no value of a point\nexpected a finite number, such as 1.5")
    return value
