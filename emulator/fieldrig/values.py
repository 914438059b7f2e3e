"""Values of points as people type them and as devices take them."""

from contextlib import suppress
from functools import partial

from fieldrig.device import Value

TRUTHS: dict[str, bool] = {"true": True, "false": False, "on": True, "off": False}


def parse_value(text: str) -> Value:
    """`true` and `on`, `12` and `0x1F`, `2.5` and `1e-3`; anything else is text.  010 is ten, as in a rig file."""
    truth = TRUTHS.get(text.lower())
    if truth is not None:
        return truth
    for read in (int, partial(int, base=0), float):
        with suppress(ValueError):
            number: Value = read(text)
            return number
    return text


def fitting(value: Value, present: Value) -> Value:
    """The same value in the type of the present one, where nothing is lost by it."""
    if isinstance(value, bool) or type(value) is type(present):
        return value
    if isinstance(present, bool) and value in (0, 1):
        return bool(value)
    if isinstance(present, float) and isinstance(value, int):
        return float(value)
    if isinstance(present, int) and isinstance(value, float) and value.is_integer():
        return int(value)
    return str(value) if isinstance(present, str) else value


def show_number(value: float) -> str:
    """With all its digits: the shortest text that is read back as the same number; whole ones without `.0`."""
    return str(value).removesuffix(".0")
