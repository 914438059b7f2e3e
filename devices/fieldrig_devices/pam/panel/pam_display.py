"""`PamDisplay`, the object that applications write to (section 7.2 of the digest)."""

from collections.abc import Callable, Sequence
from typing import Any, Final

from fieldrig_devices.pam.panel.codes import MOST_NUMBER, Code, Kind
from fieldrig_devices.pam.runtime.item import Item, RoutineRef, Value

LONGEST_TEXT: Final = 40
_KINDS: Final = {
    "message": Kind.MESSAGE,
    "warning": Kind.WARNING,
    "end_warning": Kind.END_WARNING,
    "error": Kind.ERROR,
    "end_error": Kind.END_ERROR,
}


class PamDisplay:
    """The one item of the object."""

    def __init__(
        self, show: Callable[[Code, str, tuple[int | float, ...]], None], monitor: Callable[[float], None]
    ) -> None:
        self._show, self._monitor = show, monitor
        self._value = 0.0

    def value(self) -> Value:
        return self._value

    def set_value(self, value: Value) -> None:
        self._value = float(value)
        self._monitor(self._value)

    def do(self, function: str, arguments: Sequence[Any]) -> None:
        number, text, *parameter = arguments
        code = Code(0, _KINDS[function], int(number) & MOST_NUMBER)
        self._show(code, str(text)[:LONGEST_TEXT], tuple(parameter))

    def ask(self, function: str, arguments: Sequence[Any]) -> Value:
        raise LookupError(f"PamDisplay has no inquiry {function}")

    def parameter(self, name: str) -> Value:
        raise LookupError(f"PamDisplay has no parameter {name}")

    def set_parameter(self, name: str, value: "Value | str | RoutineRef | Item") -> None:
        raise LookupError(f"PamDisplay has no parameter {name}")
