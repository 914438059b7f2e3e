"""The objects of one axis in a dictionary: numbers that are at hand, and who reads and writes them.

Numbers are kept beside the bytes and follow them, so that a cycle costs no decoding.  What the axis itself shows has
none.
"""

from collections.abc import Callable
from functools import partial

from fieldrig_devices.canopen.abort import Abort
from fieldrig_devices.canopen.datatypes import DataType, Integer
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.variable import Variable
from fieldrig_devices.cia402.objects import AXIS_STEP, ROWS

Read = Callable[[], int]
Write = Callable[[int], None]


class AxisObjects:
    """`numbers` has the values by index of the first axis and sub-index: `numbers[0x6081, 0]`."""

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
        """Called after each change of a parameter, but not of what comes in every cycle."""
        self.reload()

    def reload(self) -> None:
        """The dictionary has been put back to its start values."""
        for key, variable in self._variables.items():
            self.numbers[key] = _number(variable)

    def __getitem__(self, index: int) -> int:
        return self.numbers[index, 0]

    def variable(self, index: int, subindex: int = 0) -> Variable:
        return self._variables[index, subindex]

    def put(self, index: int, value: int, subindex: int = 0) -> None:
        """By the axis; what is too large for the type is at its limit."""
        variable = self._variables[index, subindex]
        variable.set(encoded(variable.type, value))

    def read_by(self, index: int, read: Read) -> None:
        variable = self._variables[index, 0]
        type = variable.type
        assert isinstance(type, Integer)
        size, is_signed = type.size, type.is_signed

        def shown() -> bytes:
            value = read()
            try:
                return value.to_bytes(size, "little", signed=is_signed)
            except OverflowError:
                return encoded(type, value)

        variable.reader = shown

    def on_write(self, index: int, act: Write, subindex: int = 0) -> None:
        """`act` gets each value that is written, also an equal one, and may refuse it with Abort."""
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


def encoded(type: DataType, value: int) -> bytes:
    assert isinstance(type, Integer)
    return min(max(value, type.low), type.high).to_bytes(type.size, "little", signed=type.is_signed)


def _number(variable: Variable) -> int:
    return int.from_bytes(variable.data, "little", signed=_is_signed(variable.type))


def _is_signed(type: DataType) -> bool:
    return isinstance(type, Integer) and type.is_signed
