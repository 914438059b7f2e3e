"""The object dictionary: every variable of the node by index and sub-index.

Source: CiA 301 chapter 7.4.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.variable import Variable

KEY = re.compile(r"([0-9A-Fa-f]{4}):([0-9A-Fa-f]{2})")


class Features(NamedTuple):
    """What the device can do besides its objects (section DeviceInfo of the EDS)."""

    has_lss: bool = False
    has_mpdo: bool = False
    bit_rates: tuple[int, ...] = ()
    """In bit/s."""


class Dictionary:
    """All variables; which there are is fixed from the start."""

    def __init__(
        self,
        variables: Iterable[Variable],
        dummies: Mapping[int, int] | None = None,
        features: Features | None = None,
    ) -> None:
        self.features = features or Features()
        self._objects: dict[int, dict[int, Variable]] = {}
        for variable in variables:
            self._objects.setdefault(variable.index, {})[variable.subindex] = variable
        self.dummies = dict(dummies or {})
        """Bits of each data type that RPDOs may map to leave a gap, by its index (CiA 301, dummy mapping)."""

    def __iter__(self) -> Iterator[Variable]:
        """In order of index and sub-index."""
        for index in sorted(self._objects):
            members = self._objects[index]
            for subindex in sorted(members):
                yield members[subindex]

    def __contains__(self, index: int) -> bool:
        return index in self._objects

    def indices(self, first: int, last: int) -> list[int]:
        return sorted(index for index in self._objects if first <= index <= last)

    def find(self, index: int, subindex: int) -> Variable:
        """Abort, as SDO asks for it, if there is none."""
        members = self._objects.get(index)
        if members is None:
            raise Abort(Code.NO_OBJECT)
        variable = members.get(subindex)
        if variable is None:
            raise Abort(Code.NO_SUB_INDEX)
        return variable

    def get(self, index: int, subindex: int = 0) -> Variable | None:
        return self._objects.get(index, {}).get(subindex)

    def members(self, index: int) -> list[Variable]:
        """The variables of an object from sub-index 1 on, but for FFh, which tells its structure."""
        return [member for sub, member in sorted(self._objects.get(index, {}).items()) if 0 < sub < 0xFF]

    def number(self, index: int, subindex: int, default: int = 0) -> int:
        """The value of an unsigned parameter, or `default` if the node hasn't got it."""
        variable = self.get(index, subindex)
        return default if variable is None else variable.number

    def by_key(self, key: str) -> Variable:
        """The variable `6200:01`.  ValueError, saying what would be right."""
        match = KEY.fullmatch(key)
        if match is None:
            raise ValueError(f"{key!r} is no object: index and sub-index in hex would be right, such as '6200:01'")
        variable = self.get(int(match[1], 16), int(match[2], 16))
        if variable is None:
            raise ValueError(f"there is no {key} in the EDS; {self._nearest(int(match[1], 16))}")
        return variable

    def _nearest(self, index: int) -> str:
        if index in self._objects:
            subs = ", ".join(f"{index:04X}:{sub:02X}" for sub in sorted(self._objects[index]))
            return f"object {index:04X}h has {subs}"
        near = sorted(self._objects, key=lambda one: abs(one - index))[:3]
        return "near it are " + ", ".join(f"{one:04X}h" for one in sorted(near))

    def restore(self, first: int, last: int) -> None:
        """Put the power-on values into objects `first` to `last`, but for what the machine says.

        Nobody is told: who asks for it starts all services anew.
        """
        for index, members in self._objects.items():
            if first <= index <= last:
                for variable in members.values():
                    if not variable.is_process_input:
                        variable.data = variable.start
