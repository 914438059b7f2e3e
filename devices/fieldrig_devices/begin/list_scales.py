"""The factors in a list of registers: numbers as people write them, and names of other registers."""

import re
from collections.abc import Callable, Iterable
from typing import Any, Final

POWER: Final = re.compile(r"10\s*(?:\^|\*\*)\s*\(?([-+]?\d)\)?")
PRODUCT: Final = re.compile(r"(?P<factor>[-+\d.,e]+)\s*[x*×]\s*(?P<name>[A-Za-z_]\S*)")
"""A number, and the name of a register that multiplies it."""
NOTHING: Final = frozenset(("", "-", "–", "/", "none", "n/a", "na", "n.a.", "keine"))


def factor(text: str, number_in: Callable[[str], float | None]) -> float | None:
    """Return a factor such as `0.1`, `x0.1`, `/10`, `1/10`, `10^-1` or `0.1 V`."""
    plain = text.strip().lstrip("x*×").strip()
    power = POWER.fullmatch(plain)
    if power is not None:
        return 10.0 ** int(power[1])
    dividend, slash, divisor = plain.partition("/")
    if not slash or not re.match(r"\s*\d", divisor):
        return (
            number_in(re.sub(r"\s*[^\W\d]*(?:/\w+)?$|\s*[%°]\w*$", "", plain))
            if plain[:1].isdigit()
            else number_in(plain)
        )
    over, under = number_in(dividend or "1"), number_in(divisor)
    return None if over is None or not under else over / under


def name_registers(entries: Iterable[dict[str, Any]], wanted: dict[str, str], exponents: set[str]) -> list[str]:
    """Let the entries that are `wanted` take their factor from the register of that name.

    A register of `exponents`, such as a `sunssf` of SunSpec, is a power of ten.  Return the names of the entries whose
    factor is no register either.
    """
    known = {entry["name"]: entry for entry in entries}
    unknown = []
    for name, other in wanted.items():
        if other in known and other != name and other not in wanted and not known[other]["type"].startswith("string"):
            known[name]["exponent_from" if other in exponents else "factor_from"] = other
        else:
            unknown.append(name)
    return unknown
