"""A breakpoint without its place: its condition, its count, and a text for the log instead of a stop.

Source: Debug Adapter Protocol, SourceBreakpoint.  The protocol leaves the form of a count to the debugger: `5` stops at
the fifth time, `>= 5` from then on, and `% 5` at every fifth one.  The condition is judged first, and what it refuses
does not count.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import eq, ge, gt, le, lt
from typing import Final

from fieldrig.outside.untrusted import shown

_COUNT: Final = re.compile(r"\s*(==|=|>=|>|<=|<|%)?\s*(\d{1,9})\s*")
_PART: Final = re.compile(r"\{([^{}]+)\}")
_RULES: Final[Mapping[str, Callable[[int, int], bool]]] = {
    "==": eq,
    "=": eq,
    ">=": ge,
    ">": gt,
    "<=": le,
    "<": lt,
    "%": lambda count, number: number > 0 and count % number == 0,
}


EXPECTED: Final = "expected a number, perhaps behind =, >, >=, <, <= or %"


def is_count(text: str) -> bool:
    """True for the count of a breakpoint, also for the empty one."""
    return not text or _COUNT.fullmatch(text) is not None


@dataclass(slots=True)
class Stop:
    """The behaviour of a breakpoint where the program reaches it."""

    condition: str = ""
    """An expression; an empty one always holds."""
    hits: str = ""
    """The count at which it stops; an empty one means every time."""
    log: str = ""
    """The text for the log, with expressions in braces; the program does not stop for it."""
    count: int = field(default=0, compare=False)
    """How often its condition has held."""

    def __post_init__(self) -> None:
        if not is_count(self.hits):
            raise ValueError(f"{shown(self.hits)} is no count\n{EXPECTED}")

    def is_due(self) -> bool:
        """Count the program's arrival, and return whether it is one to stop at, or to log."""
        self.count += 1
        match = _COUNT.fullmatch(self.hits)
        return match is None or _RULES[match[1] or "=="](self.count, int(match[2]))

    def text(self, value: Callable[[str], str]) -> str:
        """Return the text for the log; `value` gives that of an expression."""
        return _PART.sub(lambda part: value(part[1].strip()), self.log)
