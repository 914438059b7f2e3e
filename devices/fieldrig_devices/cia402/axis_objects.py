"""The objects of one axis in a dictionary, with their values as numbers.

The numbers are kept beside the bytes and follow them, so that a cycle costs no decoding.  Objects whose values the axis
itself shows have no number.
"""

from collections.abc import Callable
from functools import partial

from fieldrig_devices.canopen.abort import Abort
from fieldrig_devices.canopen.datatypes import DataType, Integer
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.live import encoded, show_number
from fieldrig_devices.canopen.variable import Variable
from fieldrig_devices.cia402.objects import AXIS_STEP, ROWS

Read = Callable[[], int]
Write = Callable[[int], None]


class AxisObjects:
    """`numbers` holds the values by sub-index and by the index of the first axis: `numbers[0x6081, 0]`."""

    def __init__(self, dictionary: Dictionary, axis: int) -> None:
        self._variables: dict[tuple[int, int], Variable] = {}
        self.numbers: dict[tuple[int, int], int] = {}
        for row in ROWS:
            variable = dictionary.find(row.index + axis * AXIS_STEP, row.subindex or 0)
            key = row.index, row.subindex or 0
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
            self.numbers[key] = _number(variable)

    def __getitem__(self, index: int) -> int:
        return self.numbers[index, 0]

    def variable(self, index: int, subindex: int = 0) -> Variable:
        return self._variables[index, subindex]

    def put(self, index: int, value: int, subindex: int = 0) -> None:
        """Set a value that the axis shows, limited to the range of its type."""
        variable = self._variables[index, subindex]
        variable.set(encoded(variable.type, value))

    def read_by(self, index: int, read: Read) -> None:
        """Let the network read the number that `read` returns."""
        show_number(self._variables[index, 0], read)

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

    def _take(self, key: tuple[int, int], variable: Variable) -> None:
        self.numbers[key] = _number(variable)
        self.changed()

    def _take_target(self, key: tuple[int, int], variable: Variable) -> None:
        self.numbers[key] = _number(variable)


def _number(variable: Variable) -> int:
    return int.from_bytes(variable.data, "little", signed=_is_signed(variable.type))


def _is_signed(type: DataType) -> bool:
    return isinstance(type, Integer) and type.is_signed
