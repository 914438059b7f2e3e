"""The values in a message, one by one: what a comparison of two messages says about them.

A namer that knows the parts of its messages has a method `parts`.  It depends on nothing but its arguments and on what
the namer has learned of the bus, so messages may be given in any order.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple, Protocol, runtime_checkable

NO_BITS: Final[Mapping[int, str]] = {}
MOST_BITS: Final = 4
"""Bits that are named in one line."""


class Part(NamedTuple):
    """One value of a message."""

    key: str
    """Its address in the words of the bus, such as `6041h`; two messages are compared by it."""
    name: str
    """Its name in the EDS or register table; empty if it has none."""
    value: int | float | str
    text: str
    """The value with its unit, as a person reads it."""
    bits: Mapping[int, str] = NO_BITS
    """The names of its bits, for a value that is a set of bits."""

    @property
    def label(self) -> str:
        return f"{self.key} {self.name}" if self.name else self.key


class Parts(NamedTuple):
    """A message taken apart."""

    node: str
    """The device that it comes from or goes to."""
    kind: str
    values: Sequence[Part]


@runtime_checkable
class HasParts(Protocol):
    """A namer that takes messages apart."""

    def parts(self, message: Any, request: bytes = b"") -> Parts | None:
        """Return the values of a message; None for one whose values are not known.

        `request` is the content of the request that a Modbus response answers.
        """


class PartDifference(NamedTuple):
    """Two values of one part that are not the same; None where a message does not have the part."""

    expected: Part | None
    actual: Part | None

    @property
    def key(self) -> str:
        part = self.expected or self.actual
        return "" if part is None else part.key

    @property
    def label(self) -> str:
        part = self.expected or self.actual
        return "" if part is None else part.label

    @property
    def bits(self) -> str:
        """The bits that are not the same, such as `bit 10, target reached`; empty for a value without bits."""
        expected, actual = self.expected, self.actual
        if expected is None or actual is None or not expected.bits:
            return ""
        if not isinstance(expected.value, int) or not isinstance(actual.value, int):
            return ""
        flipped = expected.value ^ actual.value
        found = [f"bit {bit}, {name}" for bit, name in expected.bits.items() if flipped >> bit & 1]
        more = [f"{len(found) - MOST_BITS} more"] if len(found) > MOST_BITS else []
        return "; ".join([*found[:MOST_BITS], *more])


def differences(expected: Sequence[Part], actual: Sequence[Part]) -> Iterator[PartDifference]:
    """Yield the parts whose values are not the same, in the order of the message."""
    came = {part.key: part for part in actual}
    for part in expected:
        other = came.pop(part.key, None)
        if other is None or other.value != part.value:
            yield PartDifference(part, other)
    for other in came.values():
        yield PartDifference(None, other)
