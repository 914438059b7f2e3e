"""The values of RETAIN variables between the memory of a program and the buffered memory of the controller.

The variables of all tasks are committed when no task is within a cycle, so that the values of a cycle are kept
together.  At a boot, a value goes to the variable that has the same name and type as the one it came from.
"""

import json
from collections.abc import Callable, MutableSequence
from operator import itemgetter
from typing import Final, Protocol

from fieldrig.store import Store, StoreError
from fieldrig.untrusted import MalformedError, items, read_json, typed
from fieldrig_devices.iec.types import Value
from fieldrig_devices.max4.plc.retain import LONGEST_MAP, RetainMap
from fieldrig_devices.max4.storage.retained import Retained

_DEEPEST: Final = 4


class Ram(Protocol):
    """The buffered RAM, whose retain data may move to another place."""

    @property
    def retained(self) -> Retained: ...


class RetainStore:
    """The retained values of one loaded program."""

    def __init__(self, ram: Ram, maps: Store, map: RetainMap, memory: MutableSequence[Value]) -> None:
        """`maps` has the maps of the values in RAM and of this program."""
        self._ram, self._maps, self._map, self._memory = ram, maps, map, memory
        addresses = [leaf.address for leaf in map.leaves]
        getter = itemgetter(*addresses) if addresses else None
        self._get: Callable[[MutableSequence[Value]], tuple[Value, ...]] | None = None
        if getter is not None:
            one = len(addresses) == 1
            self._get = (lambda cells: (getter(cells),)) if one else getter
        self._last: tuple[Value, ...] | None = None

    def restore(self) -> None:
        """Give the variables the values that were committed last."""
        before = self._ram.retained.values
        known = self._known_maps().get(before.mark) if before is not None else None
        if before is not None and known is not None:
            values = known.unpack(before.data)
            for leaf in self._map.leaves:
                value = values.get((leaf.path.casefold(), leaf.type))
                if value is not None:
                    self._memory[leaf.address] = value
        self.begin()

    def restore_nothing(self) -> None:
        """Begin with the values that the variables have, and forget those of before."""
        self._ram.retained.clear()
        self.begin()

    def begin(self) -> None:
        """Keep the names of the values in RAM until the first commit, and those of this program from then on."""
        self._last = None
        if self._get is None:
            return
        known, own, before = self._known_maps(), self._map, self._ram.retained.values
        kept = {own.mark: own}
        if before is not None and before.mark in known:
            kept[before.mark] = known[before.mark]
        if kept.keys() - known.keys():
            self._save(kept)

    def commit(self) -> None:
        """Commit the values if one has changed since the last time."""
        if self._get is None:
            return
        values = self._get(self._memory)
        if values != self._last:
            self._last = values
            self._ram.retained.commit(self._map.pack(values))

    def _known_maps(self) -> dict[bytes, RetainMap]:
        try:
            rows = read_json(self._maps.load() or b"[]", longest=LONGEST_MAP, deepest=_DEEPEST)
            found = [RetainMap.decode(typed(text, str).encode()) for text in items(rows, str, 2)]
        except MalformedError:
            return {}
        return {map.mark: map for map in found}

    def _save(self, maps: dict[bytes, RetainMap]) -> None:
        try:
            self._maps.save(json.dumps([map.encode().decode() for map in maps.values()]).encode())
        except StoreError:
            return  # the flash disk is full or broken, and says so; the values last until the next boot
