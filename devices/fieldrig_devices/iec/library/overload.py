"""A standard function for certain argument types: its Python, its result, and what it costs."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec.types import Type

# Costs in nanoseconds of a controller of 2003 with a Pentium; the digest gives orders of magnitude (PD-080).
SIMPLE_NS: Final = 50
REAL_NS: Final = 200
TEXT_NS: Final = 1_000

_MARK: Final = re.compile(r"\{(\d+|\*)\}")


@dataclass(frozen=True, slots=True)
class Implementation:
    """The Python of a function.  {0}, {1} ... are its arguments, each used exactly once; {*} is all of them.

    Besides brackets and arithmetic the text uses only the names in `intrinsics.IMPLEMENTATIONS`.  Its result is in the
    range of the result type already, and a REAL is rounded to single precision.
    """

    python: str
    cost_ns: int = SIMPLE_NS

    def expand(self, arguments: Sequence[str]) -> str:
        """Put the texts of the arguments in; each is put into brackets."""
        return expand(self.python, arguments)


@dataclass(frozen=True, slots=True)
class Overload:
    """A standard function for the types of a call; the arguments must be converted to `parameters`."""

    name: str
    """The name in `program.Intrinsic`, which `intrinsics.implementation` knows."""
    parameters: tuple[Type, ...]
    result: Type
    implementation: Implementation

    @property
    def python(self) -> str:
        return self.implementation.python

    @property
    def cost_ns(self) -> int:
        return self.implementation.cost_ns


def expand(python: str, arguments: Sequence[str]) -> str:
    bracketed = [argument if argument.isidentifier() else f"({argument})" for argument in arguments]

    def put_in(mark: re.Match[str]) -> str:
        return ", ".join(bracketed) if mark[1] == "*" else bracketed[int(mark[1])]

    return _MARK.sub(put_in, python)
