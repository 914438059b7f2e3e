"""The variables as a master knows them: definitions, keys and last values."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

from fieldrig_devices.pam.language.ports import ALL_ITEMS, PortVariable
from fieldrig_devices.pam.runtime.item import Value

_TYPES: Final[Mapping[str, type[bool | int | float]]] = {
    "FLAG_VAR": bool,
    "WORD_VAR": int,
    "LONG_VAR": int,
    "REAL_VAR": float,
}
UNKNOWN: Final = -1
"""The key of a variable that the two sides define differently, or that only one of them has."""


class Definitions:
    """An output has its place among the outputs, from 1, as its key; the PAM gives keys to the inputs."""

    def __init__(self, variables: Iterable[PortVariable], codes: Mapping[str, int]) -> None:
        """`codes` are the numbers of the classes on the wire."""
        wanted = list(variables)
        self._codes = codes
        self.inputs = {variable.crc: variable for variable in wanted if variable.is_input}
        self.outputs = [variable for variable in wanted if not variable.is_input]
        self.values: dict[str, list[Value]] = {variable.name: _zeros(variable) for variable in wanted}
        self.mistakes: list[str] = []
        self._by_name = {variable.name: variable for variable in wanted}
        self._keys: dict[str, int] = {}

    def forget_keys(self) -> None:
        self._keys.clear()

    def begin_outputs(self) -> None:
        """Set all outputs to 0, as a PAM does that starts; it sends only what changes."""
        for variable in self.outputs:
            self.values[variable.name] = _zeros(variable)

    def key(self, name: str) -> int:
        return self._keys.get(name, UNKNOWN)

    def input(self, name: str) -> PortVariable:
        """Return an input.  LookupError if there is none of this name."""
        variable = self._by_name[name]
        if not variable.is_input:
            raise LookupError(f"{name} is an output of the PAM")
        return variable

    def take_input(self, crc: int, key: int, code: int, number: int) -> None:
        """Take the PAM's definition of an input over."""
        variable = self.inputs.get(crc)
        if variable is None:
            self.mistakes.append(f"the input with the CRC {crc:#06x} is unknown")
        else:
            self._take(variable, key, code, number)

    def take_output(self, key: int, code: int, number: int) -> None:
        """Take the PAM's definition of an output over."""
        self._take(self.outputs[key - 1], key, code, number)

    def _take(self, variable: PortVariable, key: int, code: int, number: int) -> None:
        is_same = (self._codes[variable.kind], variable.number) == (code, number)
        self._keys[variable.name] = key if is_same else UNKNOWN
        if not is_same:
            self.mistakes.append(f"{variable.name} has the class {code} and {number} items on the PAM")

    def initial(self, given: Mapping[str, Value | Sequence[Value]]) -> Iterator[tuple[PortVariable, int, Value]]:
        """Yield the initial value of each item of the inputs; those that are not given are 0."""
        for variable in self.inputs.values():
            yield from each_item(variable, given.get(variable.name, 0))

    def output(self, key: int) -> PortVariable | None:
        """Return the output of a key that came with a value; None if there is none, or if it is not to be used."""
        if not 1 <= key <= len(self.outputs):
            self.mistakes.append(f"a value has the unknown key {key}")
            return None
        variable = self.outputs[key - 1]
        return variable if self.key(variable.name) == key else None

    def keep(self, variable: PortVariable, index: int, value: Value) -> bool:
        """Keep a value as one of the variable's class; return False if there is no such item."""
        values, value = self.values[variable.name], _TYPES[variable.kind](value)
        if index & ALL_ITEMS == ALL_ITEMS:
            values[:] = [value] * len(values)
        elif index < len(values):
            values[index] = value
        else:
            self.mistakes.append(f"{variable.name} has no item {index}")
            return False
        return True


def _zeros(variable: PortVariable) -> list[Value]:
    return [_TYPES[variable.kind](0)] * variable.number


def each_item(variable: PortVariable, given: Value | Sequence[Value]) -> Iterator[tuple[PortVariable, int, Value]]:
    """Yield the items with their values: a single value is that of all items."""
    values = [given] * variable.number if isinstance(given, bool | int | float) else given
    for index, value in enumerate(values):
        yield variable, index, value
