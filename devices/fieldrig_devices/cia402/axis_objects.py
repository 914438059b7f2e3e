"""The objects of one axis in a dictionary, with their values as numbers.

The numbers are kept beside the bytes and follow them, so that a cycle costs no decoding.  Objects whose values the axis
itself shows have no number.  A dictionary may lack objects, as that of another maker's drive does; an axis works with a
default instead of each of them, which no master sees.
"""

from collections.abc import Callable, Collection, Mapping
from functools import partial
from types import MappingProxyType
from typing import Final

from fieldrig_devices.canopen.abort import Abort
from fieldrig_devices.canopen.datatypes import DATA_TYPES, DataType, Integer
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.live import encoded, show_number
from fieldrig_devices.canopen.variable import Access, Variable
from fieldrig_devices.cia402.objects import MAX_CURRENT, MAX_TORQUE, ROWS, Row
from fieldrig_devices.drive_profile.objects import AXIS_STEP

Read = Callable[[], int]
Write = Callable[[int], None]
Key = tuple[int, int]
"""Index of the first axis, and sub-index."""
NOTHING: Final[Mapping[Key, int]] = MappingProxyType({})
_MAY_BE_NOTHING: Final[Collection[int]] = (MAX_TORQUE, MAX_CURRENT)
"""Limits that a master may set to 0, for no torque; a 0 at power-on says that the file does not know them."""


class AxisObjects:
    """`numbers` holds the values by sub-index and by the index of the first axis: `numbers[0x6081, 0]`."""

    def __init__(self, dictionary: Dictionary, axis: int, defaults: Mapping[Key, int] = NOTHING) -> None:
        """`defaults` are the numbers to use where the dictionary lacks the object, or where its value is 0."""
        self._variables: dict[Key, Variable] = {}
        self._defaults = defaults
        self.numbers: dict[Key, int] = {}
        self.missing: set[Key] = set()
        """The objects that the dictionary lacks."""
        for row in ROWS:
            key = row.index, row.subindex or 0
            variable = find(dictionary, row, axis)
            if variable is None:
                self.missing.add(key)
                variable = _stand_in(row, defaults.get(key))
            self._variables[key] = variable
            if row.access != "ro":
                take = self._take if row.access == "rw" else self._take_target
                variable.watchers.append(partial(take, key, variable))
        self.changed: Callable[[], None] = lambda: None
        """Called after each change of a parameter, but not of a value that a master writes in every cycle."""
        self.reload()

    def reload(self) -> None:
        """Read all numbers again, after the dictionary has been reset to its start values."""
        for key, variable in self._variables.items():
            self.numbers[key] = self._number(key, variable)

    def use_defaults(self, defaults: Mapping[Key, int]) -> None:
        """Use other numbers where the dictionary lacks the object, or where its value is 0."""
        self._defaults = defaults
        for key in self.missing & defaults.keys():
            variable = self._variables[key]
            variable.data = encoded(variable.type, defaults[key])
        self.reload()

    def __getitem__(self, index: int) -> int:
        return self.numbers[index, 0]

    def variable(self, index: int, subindex: int = 0) -> Variable:
        return self._variables[index, subindex]

    def put(self, index: int, value: int, subindex: int = 0) -> None:
        """Set a value that the axis shows, limited to the range of its type."""
        variable = self._variables[index, subindex]
        variable.set(encoded(variable.type, value))

    def read_by(self, index: int, read: Read, subindex: int = 0) -> None:
        """Let the network read the number that `read` returns."""
        show_number(self._variables[index, subindex], read)

    def on_write(self, index: int, act: Write, subindex: int = 0) -> None:
        """Call `act` with each value that is written, changed or not; `act` may refuse it with Abort."""
        variable = self._variables[index, subindex]

        def write(data: bytes) -> None:
            before = variable.data
            variable.set(data)
            try:
                act(int.from_bytes(data, "little", signed=_is_signed(variable.type)))
            except Abort:
                variable.set(before)
                raise

        variable.writer = write

    def or_start(self, index: int, check: Write, subindex: int = 0) -> Write:
        """Return `check` for all numbers but the power-on value, which a maker's file may have beyond the standard."""
        variable = self._variables[index, subindex]

        def checked(number: int) -> None:
            if encoded(variable.type, number) != variable.start:
                check(number)

        return checked

    def _number(self, key: Key, variable: Variable) -> int:
        number = int.from_bytes(variable.data, "little", signed=_is_signed(variable.type))
        is_written = key[0] in _MAY_BE_NOTHING and any(variable.start)
        return number if number or is_written else self._defaults.get(key, 0)

    def _take(self, key: Key, variable: Variable) -> None:
        self.numbers[key] = self._number(key, variable)
        self.changed()

    def _take_target(self, key: Key, variable: Variable) -> None:
        self.numbers[key] = self._number(key, variable)


def find(dictionary: Dictionary, row: Row, axis: int = 0) -> Variable | None:
    """Return the variable of a row in a dictionary; None if it has none that holds a whole number.

    Some drives have a plain variable where the standard has an array; it counts as the first element.
    """
    index = row.index + axis * AXIS_STEP
    variable = dictionary.get(index, row.subindex or 0)
    if variable is None and row.subindex == 1 and not dictionary.members(index):
        variable = dictionary.get(index)
    return variable if variable is not None and isinstance(variable.type, Integer) else None


def _stand_in(row: Row, value: int | None) -> Variable:
    """Return a variable that belongs to no dictionary."""
    kind = DATA_TYPES[row.type]
    start = row.start if isinstance(row.start, int) else 0
    data = encoded(kind, start if value is None else value)
    return Variable(row.index, row.subindex or 0, row.name, kind, Access(row.access), start=data)


def _is_signed(type: DataType) -> bool:
    return isinstance(type, Integer) and type.is_signed
