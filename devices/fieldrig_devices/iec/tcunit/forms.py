"""The texts of TcUnit: values, and lines of the report.

Source: TcUnit 1.3.2.  Values have the forms of conversions to STRING, apart from a DT, which always has its seconds,
and from bit strings, of which all digits are written.
"""

from collections.abc import Callable, Sequence
from typing import Final

from fieldrig_devices.iec import literal_texts
from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.library import texts
from fieldrig_devices.iec.literal_texts import S_NS
from fieldrig_devices.iec.types import Value

LONGEST_LINE: Final = 253
"""The most characters of a line that ADSLOGSTR writes with a text in it."""
NAME_TOO_LONG: Final = "...TestName too long"
MESSAGE_TOO_LONG: Final = "...TestMsg too long"
MOST_BYTES: Final = 39
"""The most bytes of a value that is neither elementary nor a text."""


def of_value(value: Value, kind: Elementary) -> str:
    """Return the text of an elementary value."""
    return writer(kind)(value)


def writer(kind: Elementary) -> Callable[..., str]:
    """Return the function that writes values of a type."""
    if kind is Elementary.DT:
        return lambda value: literal_texts.date_text("DT", int(value), S_NS)
    if kind.family is Family.BITS:
        return lambda value: f"0x{int(value):0{2 * kind.size}X}"
    return texts.writer(kind)


def of_bytes(data: bytes) -> str:
    """Return the text of a value of a structured type."""
    return f"0x{data[:MOST_BYTES].hex().upper()}"


Bounds = Sequence[tuple[int, int]]
"""The lowest and the highest index of each dimension."""


def of_element(indexes: Sequence[int], text: str) -> str:
    return f"ARRAY[{','.join(map(str, indexes))}] = {text}"


def of_size(bounds: Bounds) -> str:
    """Return the size of an array: of one dimension the number of its elements, otherwise the limits."""
    counts = [high - low + 1 for low, high in bounds]
    if len(bounds) == 1:
        return f"SIZE = {counts[0]}"
    limits = ",".join(f"{low}..{high}" for low, high in bounds)
    return f"SIZE = [{limits}] ({'x'.join(map(str, counts))})"


def failed(path: str, expected: str, actual: str, message: str) -> str:
    """Return the line of a failed assert; `path` is that of the suite with the name of the test."""
    front = f"FAILED TEST '{path}', EXP: {expected}, ACT: {actual}"
    if message:
        front += ", MSG: %s"
    front, message = adjusted(front, message)
    return front.replace("%s", message, 1) if message else front


def adjusted(front: str, message: str) -> tuple[str, str]:
    """Return the text of a line and the message in it, so that both have at most LONGEST_LINE characters together."""
    if len(front) + len(message) <= LONGEST_LINE:
        return front, message
    if len(front) <= LONGEST_LINE - len(MESSAGE_TOO_LONG):
        return front, message[: LONGEST_LINE - len(MESSAGE_TOO_LONG) - len(front)] + MESSAGE_TOO_LONG
    return front[: LONGEST_LINE - len(NAME_TOO_LONG)] + NAME_TOO_LONG, ""
