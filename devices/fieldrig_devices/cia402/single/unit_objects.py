"""The units of a drive as objects: a master that writes one changes the unit.

60A8h to 60AAh are units, 608Bh to 608Eh are those of the older edition, and 6096h and 6097h are factors.
"""

from collections.abc import Callable

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.datatypes import Integer
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.service import Reset, Service
from fieldrig_devices.canopen.variable import Variable
from fieldrig_devices.cia402 import si_units
from fieldrig_devices.cia402.si_units import SiUnits


class UnitObjects(Service):
    """Calls `use` with the units after each change of them, and at each reset of the node."""

    def __init__(self, dictionary: Dictionary, use: Callable[[SiUnits], None]) -> None:
        self._dictionary, self._use = dictionary, use
        self._used: SiUnits | None = None
        for index, subindex in si_units.OBJECTS:
            variable = dictionary.get(index, subindex)
            if variable is not None and isinstance(variable.type, Integer):
                variable.watchers.append(self._look)
                if index in (si_units.POSITION, si_units.VELOCITY, si_units.ACCELERATION):
                    variable.writer = _writer_of(variable)

    def reset(self, scope: Reset) -> None:
        self._look()

    def _look(self) -> None:
        units = si_units.si_units(self._number)
        if units != self._used:
            self._used = units
            self._use(units)

    def _number(self, index: int, subindex: int) -> int | None:
        variable = self._dictionary.get(index, subindex)
        return variable.number if variable is not None and isinstance(variable.type, Integer) else None


def _writer_of(variable: Variable) -> Callable[[bytes], None]:
    def write(data: bytes) -> None:
        if data != variable.start and not si_units.is_known(variable.index, int.from_bytes(data, "little")):
            raise Abort(Code.INVALID_VALUE)
        variable.set(data)

    return write
