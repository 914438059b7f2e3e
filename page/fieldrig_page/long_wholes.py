"""Whole numbers that JavaScript would round: they go to the page, and come from it, as texts of their digits."""

import re
from typing import Any, Final

from fieldrig.device import Value
from fieldrig_page.rig_link import RigLink

EXACT: Final = (1 << 53) - 1
"""Greatest whole number that JavaScript has exactly (ECMA-262, `Number.MAX_SAFE_INTEGER`)."""
_DIGITS: Final = re.compile(r"[+-]?\d{16,40}")


def for_script(value: Any) -> Any:
    """Return a value as the page's script can have it: a whole number that its numbers would round is a text."""
    return str(value) if type(value) is int and abs(value) > EXACT else value


async def as_given(link: RigLink, device: str, key: str, value: Value) -> Value:
    """Return a value for a point as it was meant: a text of many digits, where the point has a whole number, is one."""
    if not isinstance(value, str) or _DIGITS.fullmatch(value) is None:
        return value
    present = (await link.ask(f"device/{device}/get", {"keys": [key]}))[key]
    return int(value) if type(present) is int else value
