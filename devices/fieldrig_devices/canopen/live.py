"""Objects whose values are computed when they are read.

Source: CiA 301 for the types.  Numbers are limited to the range of the type; texts are Latin-1.
"""

from collections.abc import Callable

from fieldrig_devices.canopen.datatypes import DataType, Integer
from fieldrig_devices.canopen.variable import Variable


def show_number(variable: Variable, read: Callable[[], int]) -> None:
    """Let the network read the number that `read` returns."""
    type = variable.type
    assert isinstance(type, Integer), "the EDS gives the object an integer type"
    size, is_signed = type.size, type.is_signed

    def shown() -> bytes:
        value = read()
        try:
            return value.to_bytes(size, "little", signed=is_signed)
        except OverflowError:
            return encoded(type, value)

    variable.reader = shown


def show_text(variable: Variable, read: Callable[[], str]) -> None:
    """Let the network read the text that `read` returns."""
    variable.reader = lambda: text_bytes(read())


def encoded(type: DataType, value: int) -> bytes:
    """The bytes of a number, limited to the range of its type."""
    assert isinstance(type, Integer), "the EDS gives the object an integer type"
    return min(max(value, type.low), type.high).to_bytes(type.size, "little", signed=type.is_signed)


def text_bytes(text: str) -> bytes:
    """The bytes of a text; characters outside Latin-1 become question marks."""
    return text.encode("latin-1", "replace")
