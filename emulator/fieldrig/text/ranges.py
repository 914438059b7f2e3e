"""Numbers in words, with those that follow each other as a range."""

from collections.abc import Iterable


def ranges(numbers: Iterable[int]) -> str:
    """Return the numbers in order, as in `1, 10 to 25`."""
    runs: list[tuple[int, int]] = []
    for number in sorted({*numbers}):
        if runs and number == runs[-1][1] + 1:
            runs[-1] = runs[-1][0], number
        else:
            runs.append((number, number))
    return ", ".join(str(first) if first == last else f"{first} to {last}" for first, last in runs)
