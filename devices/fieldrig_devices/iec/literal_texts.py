"""Values as the text of a constant, which `literals` reads again."""

from datetime import date, timedelta
from typing import Final

UNITS_NS: Final = {
    "d": 86_400_000_000_000,
    "h": 3_600_000_000_000,
    "m": 60_000_000_000,
    "s": 1_000_000_000,
    "ms": 1_000_000,
    "us": 1_000,
    "ns": 1,
}
"""Units of a time from the largest to the smallest, in nanoseconds."""
MS_NS: Final = UNITS_NS["ms"]
S_NS: Final = UNITS_NS["s"]
EPOCH: Final = date(1970, 1, 1)


def time_text(milliseconds: int) -> str:
    """Return the constant of a TIME, such as T#1m30s."""
    return f"T#{_parts_text(milliseconds * MS_NS)}"


def long_time_text(nanoseconds: int) -> str:
    """Return the constant of an LTIME, such as LTIME#1m30s."""
    return f"LTIME#{_parts_text(nanoseconds)}"


def _parts_text(nanoseconds: int) -> str:
    sign, rest = ("-", -nanoseconds) if nanoseconds < 0 else ("", nanoseconds)
    parts = []
    for unit, size in UNITS_NS.items():
        count, rest = divmod(rest, size)
        if count:
            parts.append(f"{count}{unit}")
    return f"{sign}{''.join(parts) or '0ms'}"


def clock_text(nanoseconds: int) -> str:
    """Return hours, minutes and seconds, with milliseconds or nanoseconds if there are any."""
    seconds, rest = divmod(nanoseconds, S_NS)
    text = f"{seconds // 3_600:02}:{seconds // 60 % 60:02}:{seconds % 60:02}"
    return f"{text}.{rest:09}" if rest % MS_NS else f"{text}.{rest // MS_NS:03}" if rest else text


def day_text(seconds: int) -> str:
    return str(EPOCH + timedelta(days=seconds // 86_400))


def date_text(kind: str, value: int, unit_ns: int) -> str:
    """Return the constant of a date or time of day; `kind` is the word in front of #, such as LDT."""
    seconds, rest = divmod(value * unit_ns, S_NS)
    if kind.endswith("TOD"):
        return f"{kind}#{clock_text(value * unit_ns)}"
    text = f"{kind}#{day_text(seconds)}"
    return f"{text}-{clock_text(seconds % 86_400 * S_NS + rest)}" if kind.endswith("DT") else text


def string_text(value: str) -> str:
    """Return a string with its quotes and escapes."""
    return "'" + "".join(map(_escaped, value)) + "'"


def wide_string_text(value: str) -> str:
    """Return a WSTRING with its quotes and escapes."""
    return '"' + "".join(map(_widely_escaped, value)) + '"'


def _widely_escaped(character: str) -> str:
    if character in '$"':
        return "$" + character
    return character if character.isprintable() else f"${ord(character):04X}"


def _escaped(character: str) -> str:
    if character in "$'":
        return "$" + character
    return character if " " <= character <= "~" or "\xa1" <= character <= "\xff" else f"${ord(character):02X}"


def real_text(value: float) -> str:
    text = repr(value).upper().replace("E+", "E")
    return text if "." in text else text.replace("E", ".0E") if "E" in text else f"{text}.0"
