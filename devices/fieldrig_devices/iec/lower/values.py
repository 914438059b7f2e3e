"""The text of a computed value, with what is known about its range.

The range of an integer may exceed its type: then the text has not been cut yet.  Sums, differences and products are the
same whether they are cut at each operation or at the end, so they are only cut where the value is used otherwise.
"""

from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.types import StringType

Stored = Elementary | StringType
LARGEST: Final = 2**62
"""Ranges beyond this are cut at once, because long integers are slow."""
_FAST: Final = 2**30 - 1
"""CPython compares integers of one digit faster, so 32-bit types are tested against this first."""


@dataclass(slots=True)
class Value:
    """A Python expression without side effects, that never raises; only integers have a range."""

    text: str
    type: Stored
    low: int = 0
    high: int = 0

    @property
    def fits(self) -> bool:
        """True if the value needs no cut."""
        kind = self.type
        if isinstance(kind, StringType) or kind.is_real or kind.family is Family.BOOL:
            return True
        return kind.low <= self.low and self.high <= kind.high

    @property
    def is_atom(self) -> bool:
        return self.text.isidentifier() or self.text.isdigit()


def of_type(text: str, kind: Stored) -> Value:
    """Return a value that can be anything that its type allows."""
    return Value(text, kind) if isinstance(kind, StringType) else Value(text, kind, kind.low, kind.high)


def constant(value: bool | int | float | str, kind: Stored) -> Value:
    if isinstance(value, str):
        return Value(repr(value), kind)
    if isinstance(kind, Elementary) and kind.is_real:
        return Value(_real(float(value)), kind)
    if kind is Elementary.BOOL:
        return Value(repr(bool(value)), kind)
    number = int(value)
    return Value(str(number) if number >= 0 else f"({number})", kind, number, number)


def _real(value: float) -> str:
    if value != value:
        return "NAN"
    if value in (float("inf"), float("-inf")):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    return repr(value) if repr(value)[0] != "-" else f"({value!r})"


def outside(name: str, value: Value) -> str:
    """The condition under which the named value has to be cut to its signed type."""
    kind = value.type
    assert isinstance(kind, Elementary)
    low, high = (kind.low, kind.high) if kind.size < 4 else (max(kind.low, -_FAST), min(kind.high, _FAST))
    if kind.size == 4 and not (value.low < -(2**33) or value.high > 2**33):
        low, high = -_FAST, _FAST
    if value.low >= kind.low:
        return f"{name} > {high}"
    if value.high <= kind.high:
        return f"{name} < {low}"
    return f"not {low} <= {name} <= {high}"
