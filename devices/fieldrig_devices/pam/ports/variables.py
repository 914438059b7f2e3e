"""The variables of ports and the objects DualPort and RS422Port, as programs see them."""

from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from typing import Any, Final

from fieldrig_devices.pam.language.ports import ALL_ITEMS, PortPlan, PortVariable
from fieldrig_devices.pam.runtime.item import Kernel, Pending, Value

IsActive = Callable[[str, int], bool]
"""Returns whether a component of a NODES_GROUP is active, by the name of the group and its number from 0."""


def _signed(value: Value, bits: int) -> int:
    """Return a whole number in the range of a class: the upper bits are lost, and infinity and NaN are 0."""
    half = 1 << bits - 1
    return (int(value) + half) % (2 * half) - half if isfinite(value) else 0


_AS_CLASS: Final[Mapping[str, Callable[[Value], Value]]] = {
    "FLAG_VAR": bool,
    "WORD_VAR": lambda value: _signed(value, 16),
    "LONG_VAR": lambda value: _signed(value, 32),
    "REAL_VAR": float,
}
_FLAG: Final[Mapping[str, Callable[[Value], bool]]] = {
    "set": lambda _: True,
    "reset": lambda _: False,
    "invert": lambda value: not value,
}


class PortItem:
    """One item of a variable."""

    __slots__ = ("_convert", "_is_active", "_kernel", "_on_change", "_value", "index", "variable")

    def __init__(
        self,
        variable: PortVariable,
        index: int,
        kernel: Kernel,
        is_active: IsActive,
        on_change: Callable[["PortItem"], None],
    ) -> None:
        """`on_change` is called when a program has changed an output."""
        self._is_active = is_active
        self.variable, self.index = variable, index
        self._kernel, self._on_change = kernel, on_change
        self._convert = _AS_CLASS[variable.kind]
        self._value = self._convert(0)

    @property
    def is_served(self) -> bool:
        """False if the item belongs to a component that is not active (PAMS-086)."""
        group = self.variable.group
        return not group or self._is_active(group, self.index)

    def value(self) -> Value:
        return self._value

    def set_value(self, value: Value) -> None:
        if self.receive(value):
            self._on_change(self)

    def receive(self, value: Value) -> bool:
        """Take a value over, which is an event if it differs from the one before.  Return whether it does."""
        converted = self._convert(value)
        if converted == self._value:
            return False
        self._value = converted
        self._kernel.touched(self.variable.name)
        return True

    def preset(self, value: Value = 0) -> None:
        """Set the value without an event, before the application runs."""
        self._value = self._convert(value)

    def ask(self, function: str, arguments: Sequence[Any]) -> Value | Pending:
        raise LookupError(f"a variable of a port has no inquiry {function}")

    def do(self, function: str, arguments: Sequence[Any]) -> None:
        self.set_value(_FLAG[function](self._value))

    def parameter(self, name: str) -> Value:
        raise LookupError(f"a variable of a port has no parameter {name}")

    def set_parameter(self, name: str, value: Any) -> None:
        raise LookupError(f"a variable of a port has no parameter {name}")


def items_of(
    variables: Sequence[PortVariable],
    kernel: Kernel,
    is_active: IsActive,
    on_change: Callable[[PortItem], None],
) -> dict[str, list[PortItem]]:
    """Return the items of each variable, by its name."""
    return {
        variable.name: [PortItem(variable, index, kernel, is_active, on_change) for index in range(variable.number)]
        for variable in variables
    }


def addressed(items: Sequence[PortItem], index: int) -> Sequence[PortItem]:
    """Return the items of an index that are served; -1 means all."""
    chosen = items if index == ALL_ITEMS else items[index : index + 1]
    return [item for item in chosen if item.is_served]


CODE_OK: Final = 1
CODE_STOPPED: Final = 2
"""The codes of PORTERR.SYS: the master is there, or it is not."""


class OutputChanges:
    """Changes of outputs on their way into an output FIFO.

    One that finds it full is lost, which is reported once until there is room again (07..E008).
    """

    def __init__(self, put: Callable[[PortItem], bool], kernel: Kernel) -> None:
        """`put` writes the present value of an output, and returns False if there is no room."""
        self._put, self._kernel = put, kernel
        self._is_full = False

    def clear(self) -> None:
        self._is_full = False

    def add(self, item: PortItem) -> None:
        is_written = self._put(item)
        if not is_written and not self._is_full:
            self._kernel.report("07..E008")
        self._is_full = not is_written


class PortStatus:
    """The object DualPort or RS422Port."""

    def __init__(self, name: str, plan: PortPlan | None, kernel: Kernel) -> None:
        """`plan` is None if there is no such port; the object never has an error then."""
        self.name, self._kernel = name, kernel
        self._code = CODE_OK
        names = () if plan is None else [part.name for part in plan.declaration.parameters]
        self._parameters: dict[str, int | None] = {
            name: plan.timeout_ms(name) for name in names if plan is not None and name.startswith(("MASTER_", "PAM_W"))
        }

    @property
    def is_error(self) -> bool:
        return self._code != CODE_OK

    def set_error(self, is_error: bool) -> None:
        code = CODE_STOPPED if is_error else CODE_OK
        if code != self._code:
            self._code = code
            self._kernel.touched(self.name)

    def duration_ns(self, name: str) -> int | None:
        """Return a parameter in nanoseconds; None for NONE, which means no limit."""
        time_ms = self._parameters.get(name)
        return None if time_ms is None else time_ms * 1_000_000

    def value(self) -> Value:
        raise LookupError(f"{self.name} has no value")

    def set_value(self, value: Value) -> None:
        raise LookupError(f"{self.name} takes no value")

    def ask(self, function: str, arguments: Sequence[Any]) -> Value | Pending:
        if function == "error":
            return self.is_error
        return self._code == int(arguments[0]) if arguments else self._code

    def do(self, function: str, arguments: Sequence[Any]) -> None:
        raise LookupError(f"{self.name} has no function {function}")

    def parameter(self, name: str) -> Value:
        """Return a time in milliseconds; 0 for NONE."""
        return self._parameters.get(name) or 0

    def set_parameter(self, name: str, value: Any) -> None:
        """Change a time; one that is negative, infinite or NaN is ignored."""
        if value == "NONE":
            self._parameters[name] = None
        elif isfinite(value) and value >= 0:
            self._parameters[name] = int(value)
