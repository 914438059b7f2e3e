"""Values by name, each with the number of its last change, for readers that want only what is new."""

from collections.abc import Mapping
from typing import Generic, TypeVar

V = TypeVar("V")


class Changes(Generic[V]):
    """Values by name.  A reader keeps the number that it has read up to; 0 is before everything."""

    def __init__(self) -> None:
        self.number = 0
        """The number of the last change."""
        self._values: dict[str, tuple[int, V]] = {}

    def put(self, name: str, value: V) -> None:
        """Set a value; the same one again is no change."""
        known = self._values.get(name)
        if known is None or known[1] != value:
            self.number += 1
            self._values[name] = self.number, value

    def since(self, number: int) -> Mapping[str, V]:
        """Return the values that changed after this number."""
        if number >= self.number:
            return {}
        return {name: value for name, (changed, value) in self._values.items() if changed > number}
