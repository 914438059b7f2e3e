"""The base of all items: functions, inquiries and parameters are found by their names."""

from collections.abc import Sequence
from typing import Any

from fieldrig_devices.pam.runtime.item import Pending, Value


class ObjectItem:
    """An executive function F is the method `do_F`, an inquiry `ask_F`, a parameter P the attribute p.

    The checker has accepted the names, so a name that is not there is a mistake in this program.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        """The name of the object."""

    def value(self) -> Value | Pending:
        raise AttributeError(f"{self.name} has no value")

    def set_value(self, value: Value) -> None:
        raise AttributeError(f"{self.name} takes no value")

    def ask(self, function: str, arguments: Sequence[Any] = ()) -> Any:
        return getattr(self, f"ask_{function}")(*arguments)

    def do(self, function: str, arguments: Sequence[Any] = ()) -> None:
        getattr(self, f"do_{function}")(*arguments)

    def parameter(self, name: str) -> Any:
        return getattr(self, name.lower())

    def set_parameter(self, name: str, value: Any) -> None:
        setattr(self, name.lower(), value)


class Switched(ObjectItem):
    """An item with a flag that programs set, reset and invert (PAML-108)."""

    is_on = False

    def value(self) -> bool:
        return self.is_on

    def do_set(self) -> None:
        self.set_value(True)

    def do_reset(self) -> None:
        self.set_value(False)

    def do_invert(self) -> None:
        self.set_value(not self.is_on)


def has_error(code: int, mask: int | None) -> int | bool:
    """Answer error_code: the whole code, or whether any bit of a mask is set (PAMS-029)."""
    return code if mask is None else bool(code & int(mask))
