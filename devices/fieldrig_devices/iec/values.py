"""The values of the variables of a loaded program, by their symbols: in its memory, or in the area %I, %Q or %M."""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.iec import characters
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.host import Host
from fieldrig_devices.iec.layout import AREAS, kind_number, storage
from fieldrig_devices.iec.memory import Memory, limited
from fieldrig_devices.iec.symbols import Symbol
from fieldrig_devices.iec.types import EnumType, StringType, SubrangeType, Type, Value

_BYTE: Final = kind_number(Elementary.BYTE)


class NoTargetError(ValueError):
    """A VAR_IN_OUT that has not been given yet, or whose variable an online change has removed."""


class Values:
    """Reads and writes without a check of the value; `checked` makes one."""

    def __init__(self, memory: Memory, areas: Mapping[str, bytearray], host: Host) -> None:
        self._memory, self._areas, self._host = memory, areas, host

    def read(self, symbol: Symbol) -> Value:
        """Return the value of a symbol; ValueError for a group, and for a VAR_IN_OUT that has not been given."""
        kind = storage(symbol.type)
        if kind is None:
            raise ValueError(f"{symbol.path} is a {symbol.type}; expected one of its parts")
        if symbol.location is not None:
            return self.read_area(symbol)
        if symbol.bit >= 0:
            return bool(int(self._memory.value(self._address(symbol), _BYTE)) >> symbol.bit & 1)
        if symbol.is_in_union:
            return self._memory.value(self._address(symbol), kind_number(kind))
        value = self._memory.cells[self._address(symbol)]
        return value if len(symbol.steps) == 1 else checked(value, symbol)

    def put(self, symbol: Symbol, value: Value) -> None:
        if symbol.location is not None:
            self.put_area(symbol, value)
        elif symbol.bit >= 0:
            rest = int(self._memory.value(self._address(symbol), _BYTE)) & ~(1 << symbol.bit)
            self._memory.put_value(self._address(symbol), _BYTE, rest | bool(value) << symbol.bit)
        elif symbol.is_in_union and (kind := storage(symbol.type)) is not None:
            self._memory.put_value(self._address(symbol), kind_number(kind), value)
        else:
            self._memory.cells[self._address(symbol)] = value

    def read_area(self, symbol: Symbol) -> Value:
        where, kind = symbol.location, storage(symbol.type)
        assert where is not None
        assert kind is not None
        if kind is Elementary.BOOL and where.bit >= 0:
            return bool(self._areas[where.area][where.byte] & 1 << where.bit)
        return self._memory.peek(AREAS[where.area] + where.byte, kind_number(kind))

    def put_area(self, symbol: Symbol, value: Value) -> None:
        where, kind = symbol.location, storage(symbol.type)
        assert where is not None
        assert kind is not None
        if kind is Elementary.BOOL and where.bit >= 0:
            rest = self._areas[where.area][where.byte] & ~(1 << where.bit)
            self._areas[where.area][where.byte] = rest | bool(value) << where.bit
            if where.area == "Q":
                self._host.on_output(where.byte)
        else:
            self._memory.poke(AREAS[where.area] + where.byte, kind_number(kind), value)

    def _address(self, symbol: Symbol) -> int:
        address = symbol.steps[0]
        for step in symbol.steps[1:]:
            reference = self._memory.cells[address]
            if not isinstance(reference, int) or not 0 < reference < len(self._memory.cells) - step:
                raise NoTargetError(f"{symbol.path} refers to nothing yet")
            address = reference + step
        return address


def checked(value: Value, symbol: Symbol) -> Value:
    """Return a value as the type of a symbol stores it; ValueError if it cannot have it."""
    kind = symbol.type
    stored = storage(kind)
    if isinstance(stored, StringType):
        if not isinstance(value, str) or len(value) > stored.length:
            raise ValueError(f"{symbol.path}: expected a text of at most {stored.length} characters, got {value!r}")
        wrong = characters.first_outside(value, is_wide=stored.is_wide)
        if wrong is not None:
            raise ValueError(f"{symbol.path}: expected characters of a {stored.name}, got {wrong!r}")
        return value
    if stored is None or isinstance(value, str):
        raise ValueError(f"{symbol.path}: expected a value of type {kind}, got {value!r}")
    if stored.is_real:
        return limited(value, stored)
    low, high = _ends(kind, stored)
    if value != value or not low <= value <= high or value != int(value):
        raise ValueError(f"{symbol.path}: expected {low} to {high}, got {value!r}")
    return bool(value) if stored is Elementary.BOOL else int(value)


def _ends(kind: Type, stored: Elementary) -> tuple[int, int]:
    if isinstance(kind, SubrangeType):
        return kind.low, kind.high
    if isinstance(kind, EnumType) and kind.values:
        return kind.ranges[0][0], kind.ranges[-1][1]
    return stored.low, stored.high
