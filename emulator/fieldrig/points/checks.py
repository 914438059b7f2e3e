"""Checks of the values that people and programs write to points, with one wording for all devices.

Each function returns the value if it fits, and raises ValueError with what was expected and what it got otherwise:
"expected a number from 0 to 10, got 11".  A check that also serves elsewhere, such as for a start value of a rig file,
is given the name of the value, which then begins the message.
"""

from collections.abc import Collection
from math import isfinite

from fieldrig.device import Value
from fieldrig.points.values import show_number


def number_in(
    value: Value,
    low: float | None = None,
    high: float | None = None,
    unit: str = "",
    name: str = "",
    *,
    below: float | None = None,
) -> int | float:
    """Return a finite number from `low` to `high`, both included, or to less than `below`."""
    if (
        isinstance(value, bool | str)
        or not isfinite(value)
        or not _is_within(value, low, high)
        or (below is not None and value >= below)
    ):
        raise _refusal(f"a number{_limits(low, high, unit, below)}", value, name)
    return value


def whole_in(value: Value, low: int | None = None, high: int | None = None, unit: str = "", name: str = "") -> int:
    """Return a whole number within the limits; 2.0 is one too."""
    if isinstance(value, bool | str) or not isfinite(value) or value != int(value) or not _is_within(value, low, high):
        raise _refusal(f"a whole number{_limits(low, high, unit)}", value, name)
    return int(value)


def truth_in(value: Value, name: str = "") -> bool:
    """Return true or false; 1 and 0 are accepted too."""
    if isinstance(value, str) or value not in (0, 1):
        raise _refusal("true or false", value, name)
    return bool(value)


def text_in(value: Value, longest: int, name: str = "") -> str:
    """Return a text of up to `longest` characters."""
    if not isinstance(value, str) or len(value) > longest:
        raise _refusal(f"a text of up to {longest} characters", value, name)
    return value


def choice_in(value: Value, choices: Collection[Value], name: str = "") -> Value:
    """Return one of `choices`."""
    if value not in choices:
        words = [str(choice) for choice in choices]
        raise _refusal(" or ".join((", ".join(words[:-1]), words[-1])) if len(words) > 1 else words[0], value, name)
    return value


def _is_within(value: float, low: float | None, high: float | None) -> bool:
    return (low is None or value >= low) and (high is None or value <= high)


def _limits(low: float | None, high: float | None, unit: str, below: float | None = None) -> str:
    """Return the limits as the end of a phrase, such as " from 0 to 10 m"; without limits only the unit."""
    limits = ""
    if low is not None and below is not None:
        limits = f" from {show_number(low)} to less than {show_number(below)}"
    elif low is not None and high is not None:
        limits = f" from {show_number(low)} to {show_number(high)}"
    elif low is not None:
        limits = f" of at least {show_number(low)}"
    elif high is not None:
        limits = f" of at most {show_number(high)}"
    return f"{limits} {unit}" if limits and unit else f" in {unit}" if unit else limits


def _refusal(expected: str, value: Value, name: str) -> ValueError:
    got = show_number(value) if isinstance(value, int | float) and not isinstance(value, bool) else repr(value)
    return ValueError(f"{name}: expected {expected}, got {got}".removeprefix(": "))
