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
    """Features of the device besides its objects (section DeviceInfo of the EDS, but for `maps_while_valid`)."""

    has_lss: bool = False
    has_mpdo: bool = False
    bit_rates: tuple[int, ...] = ()
    """Supported bit rates, in bit/s."""
    maps_while_valid: bool = False
    """True if a PDO need not be invalid while a master changes its mapping, which CiA 301 asks for."""


class Dictionary:
    """All variables of a node.  Their number is fixed; only their values change."""

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
        """Length in bits of the data types that an RPDO may map as a dummy, by index (CiA 301, dummy mapping)."""

    def __iter__(self) -> Iterator[Variable]:
        """Iterate over the variables in order of index and sub-index."""
        for index in sorted(self._objects):
            members = self._objects[index]
            for subindex in sorted(members):
                yield members[subindex]

    def __contains__(self, index: int) -> bool:
        return index in self._objects

    def indices(self, first: int, last: int) -> list[int]:
        return sorted(index for index in self._objects if first <= index <= last)

    def find(self, index: int, subindex: int) -> Variable:
        """Return a variable.  Raises Abort with the code of the standard if there is none."""
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
        """Return the variables of an object from sub-index 1 on, without FFh, which describes its structure."""
        return [member for sub, member in sorted(self._objects.get(index, {}).items()) if 0 < sub < 0xFF]

    def number(self, index: int, subindex: int, default: int = 0) -> int:
        """Return the value of an unsigned parameter, or `default` if the node doesn't have it."""
        variable = self.get(index, subindex)
        return default if variable is None else variable.number

    def by_key(self, key: str) -> Variable:
        """Return the variable for a key such as `6200:01`.  Raises ValueError, with what was expected."""
        match = KEY.fullmatch(key)
        if match is None:
            raise ValueError(f"{key!r} is not an object: expected index and sub-index in hex, such as '6200:01'")
        variable = self.get(int(match[1], 16), int(match[2], 16))
        if variable is None:
            raise ValueError(f"the EDS has no {key}; {self._nearest(int(match[1], 16))}")
        return variable

    def _nearest(self, index: int) -> str:
        if index in self._objects:
            subs = ", ".join(f"{index:04X}:{sub:02X}" for sub in sorted(self._objects[index]))
            return f"object {index:04X}h has {subs}"
        near = sorted(self._objects, key=lambda known: abs(known - index))[:3]
        return "the nearest objects are " + ", ".join(f"{known:04X}h" for known in sorted(near))

    def remove(self, index: int) -> None:
        """Take away an object with all of its sub-indices, before any service uses it; nothing if there is none."""
        self._objects.pop(index, None)

    def restore(self, first: int, last: int) -> None:
        """Set objects `first` to `last` to their power-on values, except process inputs.

        No watcher is called: the caller resets all services afterwards.
        """
        for index, members in self._objects.items():
            if first <= index <= last:
                for variable in members.values():
                    if not variable.is_process_input:
                        variable.data = variable.start
