"""Values of points as users type them and as devices take them."""

from contextlib import suppress
from functools import partial

from fieldrig.device import Value

TRUTHS: dict[str, bool] = {"true": True, "false": False, "on": True, "off": False}


def parse_value(text: str) -> Value:
    """Return `true` and `on`, `12` and `0x1F`, `2.5` and `1e-3` as values; anything else is text.  010 is ten."""
    truth = TRUTHS.get(text.lower())
    if truth is not None:
        return truth
    for read in (int, partial(int, base=0), float):
        with suppress(ValueError):
            number: Value = read(text)
            return number
    return text


def is_another(value: Value, before: Value) -> bool:
    """Return whether a value has changed; NaN after NaN has not."""
    return value != before and not (value != value and before != before)


def fitting(value: Value, present: Value) -> Value:
    """Return the value in the type of the present one, if that loses nothing."""
    if isinstance(value, bool) or type(value) is type(present):
        return value
    if isinstance(present, bool) and value in (0, 1):
        return bool(value)
    if isinstance(present, float) and isinstance(value, int):
        return float(value)
    if isinstance(present, int) and isinstance(value, float) and value.is_integer():
        return int(value)
    return str(value) if isinstance(present, str) else value


def counted(number: int, one: str, many: str = "") -> str:
    """Return `1 bus`, `2 buses`; without `many` an s makes the plural."""
    return f"{number} {one if number == 1 else many or f'{one}s'}"


def show_number(value: float) -> str:
    """Return the shortest text that is read back as the same number, without the `.0` of whole numbers."""
    return str(value).removesuffix(".0")
