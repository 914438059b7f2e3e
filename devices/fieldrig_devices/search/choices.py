"""The things that may happen in a search: for each choice a verb, a place, and the values that it may have."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any, Final, NamedTuple, Protocol

from fieldrig_devices.scenarios.act import Act, Verb

STEPS: Final = 1000
"""Values of a span of real numbers, beside its lower end."""


class Dice(Protocol):
    """The part of `random.Random` that strategies use."""

    def random(self) -> float: ...
    def randint(self, a: int, b: int) -> int: ...
    def randrange(self, start: int, stop: int) -> int: ...


class Span(NamedTuple):
    """All values from one to another."""

    low: int | float
    high: int | float


class Choice(NamedTuple):
    verb: Verb
    where: str
    values: tuple[Any, ...] = (None,)
    """Values of a place, or faults; the plainest first."""
    span: Span | None = None
    """Values of a place instead of these."""
    holds_ns: tuple[int, ...] = (0,)

    def all(self, at_ns: int) -> Iterator[Act]:
        """Yield the actions at an instant, with the ends of a span."""
        values = self.values if self.span is None else self.span
        for value, hold_ns in product(values, self.holds_ns):
            yield Act(at_ns, self.verb, self.where, value, hold_ns)

    def thrown(self, dice: Dice, at_ns: int) -> Act:
        """Return an action at an instant by chance."""
        hold_ns = one_of(dice, self.holds_ns)
        value = one_of(dice, self.values) if self.span is None else _within(dice, *self.span)
        return Act(at_ns, self.verb, self.where, value, hold_ns)

    def has(self, act: Act) -> bool:
        return (act.verb, act.where, kind_of(act)) == (self.verb, self.where, kind_of(next(self.all(0))))


def kind_of(act: Act) -> str:
    """Return what a fault is; otherwise nothing."""
    return str(act.value["what"]) if act.verb == "fault" and isinstance(act.value, Mapping) else ""


def one_of(dice: Dice, values: Sequence[Any]) -> Any:
    return values[dice.randrange(0, len(values))]


def _within(dice: Dice, low: int | float, high: int | float) -> int | float:
    if isinstance(low, int) and isinstance(high, int):
        return dice.randint(low, high)
    return low + (high - low) * dice.randint(0, STEPS) / STEPS
