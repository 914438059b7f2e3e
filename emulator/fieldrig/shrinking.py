"""Makes what fails small: fewer parts, and smaller numbers, as long as it still fails."""

from collections.abc import Callable, Sequence
from typing import TypeVar

T = TypeVar("T")


def fewest(parts: Sequence[T], fails: Callable[[list[T]], bool]) -> list[T]:
    """Return the parts that are needed to fail, of which none can be left out alone.

    `parts` fail together.  Source: A. Zeller and R. Hildebrandt, Simplifying and Isolating Failure-Inducing Input, 2002
    (ddmin, without its test of the subsets, which rarely helps with what has an order).
    """
    kept, size = list(parts), max(1, len(parts) // 2)
    while kept:
        for begin in range(0, len(kept), size):
            rest = kept[:begin] + kept[begin + size :]
            if fails(rest):
                kept = rest
                break
        else:
            if size == 1:
                break
            size = max(1, size // 2)
            continue
        size = max(1, min(size, len(kept) // 2))
    return kept


def least(number: int, low: int, fails: Callable[[int], bool]) -> int:
    """Return a number from `low` to `number` that fails, where the one below it does not; `number` fails."""
    while low < number:
        middle = (low + number) // 2
        if fails(middle):
            number = middle
        else:
            low = middle + 1
    return number
