"""A declaration with the values of its parameters, which may be missing or wrong."""

from fieldrig_devices.pam.language.items import Declaration, Parameter
from fieldrig_devices.pam.language.tree import Number, Place, Reference, Word


class Given:
    def __init__(self, declaration: Declaration) -> None:
        self.name, self.kind = declaration.name, declaration.kind
        self._values: dict[str, Parameter] = {parameter.name: parameter for parameter in declaration.parameters}
        self._place = declaration.place

    @property
    def place(self) -> Place:
        """The place of ADDRESS, or of the declaration."""
        return self._values["ADDRESS"].place if "ADDRESS" in self._values else self._place

    def integer(self, name: str) -> int | None:
        """Return a whole number; None if there is none."""
        value = self._values[name].values[0] if name in self._values else None
        return value.value if isinstance(value, Number) and isinstance(value.value, int) else None

    def text(self, name: str) -> str:
        """Return a word or the name of an object; nothing if there is none."""
        value = self._values[name].values[0] if name in self._values else None
        return value.name if isinstance(value, Word | Reference) else ""
