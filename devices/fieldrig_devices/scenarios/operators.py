"""The operators and functions of expressions."""

import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from fieldrig.device import Value

LEVELS: Final[Sequence[Mapping[str, Callable[[Any, Any], Any]]]] = (
    {"==": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge},
    {"|": operator.or_},
    {"&": operator.and_},
    {"+": operator.add, "-": operator.sub},
    {"*": operator.mul, "/": operator.truediv},
)
"""The operators by rank, the weakest first."""
CONSTANTS: Final[Mapping[str, Value]] = {"true": True, "false": False}
FUNCTIONS: Final[Mapping[str, Callable[..., Any]]] = {
    "abs": abs, "min": min, "max": max, "contains": lambda text, part: str(part) in str(text),
}  # fmt: skip
_COUNTS: Final = {"abs": (1, 1, "one"), "contains": (2, 2, "a text and a part of it")}
_MORE: Final = (2, 2_000, "at least two")


def check_count(name: str, count: int) -> None:
    """ValueError, with what was expected, for a function with a wrong number of values."""
    least, most, expected = _COUNTS.get(name, _MORE)
    if not least <= count <= most:
        raise ValueError(f"{name} has {count} values\nexpected {expected}")
