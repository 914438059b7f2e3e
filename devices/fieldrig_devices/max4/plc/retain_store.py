"""The values of RETAIN variables between the memory of a program and the buffered memory of the controller.

The variables of all tasks are committed when no task is within a cycle, so that the values of a cycle are kept
together. A value is in a cell of the memory, or in the area %M if its variable has an address there. At a boot, a value
goes to the variable that has the same name and type as the one it came from.
"""

import json
import struct
from collections.abc import Callable, MutableSequence, Sequence
from operator import itemgetter
from typing import Final, Protocol

from fieldrig.outside.untrusted import MalformedError, items, read_json, typed
from fieldrig.storage.store import Store, StoreError
from fieldrig_devices.iec import characters
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library.integers import cut
from fieldrig_devices.iec.types import Value
from fieldrig_devices.max4.plc.retain import LONGEST_MAP, Leaf, RetainMap
from fieldrig_devices.max4.storage.retained import Retained

_DEEPEST: Final = 4


class Ram(Protocol):
    """The buffered RAM, whose retain data may move to another place."""

    @property
    def retained(self) -> Retained: ...


class RetainStore:
    """The retained values of one loaded program."""

    def __init__(
        self, ram: Ram, maps: Store, map: RetainMap, memory: MutableSequence[Value], markers: bytearray
    ) -> None:
        """`maps` has the maps of the values in RAM and of this program; `markers` is the area %M."""
        self._ram, self._maps, self._map, self._memory, self._markers = ram, maps, map, memory, markers
        self._cells = _getter([leaf.address for leaf in map.leaves if leaf.marker is None])
        self._located = [leaf for leaf in map.leaves if leaf.marker is not None]
        self._last: tuple[Value, ...] | None = None

    def restore(self) -> None:
        """Give the variables the values that were committed last."""
        before = self._ram.retained.values
        known = self._known_maps().get(before.mark) if before is not None else None
        if before is not None and known is not None:
            values = known.unpack(before.data)
            for leaf in self._map.leaves:
                value = values.get((leaf.path.casefold(), leaf.type))
                if value is None and leaf.type == Elementary.SIGNED_TIME.name:  # stored before TIME had a sign
                    old = values.get((leaf.path.casefold(), Elementary.TIME.name))
                    value = cut(int(old), Elementary.SIGNED_TIME) if old is not None else None
                if value is not None and leaf.marker is not None:
                    _put(leaf, leaf.marker, value, self._markers)
                elif value is not None:
                    self._memory[leaf.address] = value
        self.begin()

    def restore_nothing(self) -> None:
        """Begin with the values that the variables have, and forget those of before."""
        self._ram.retained.clear()
        self.begin()

    def begin(self) -> None:
        """Keep the names of the values in RAM until the first commit, and those of this program from then on."""
        self._last = None
        if not self._map.leaves:
            return
        known, own, before = self._known_maps(), self._map, self._ram.retained.values
        kept = {own.mark: own}
        if before is not None and before.mark in known:
            kept[before.mark] = known[before.mark]
        if kept.keys() - known.keys():
            self._save(kept)

    def commit(self) -> None:
        """Commit the values if one has changed since the last time."""
        if not self._map.leaves:
            return
        values = self._cells(self._memory)
        if self._located:  # %M is below all cells
            values = (*(_value(leaf, self._markers) for leaf in self._located), *values)
        if values != self._last:
            self._last = values
            self._ram.retained.commit(self._map.pack(values))

    def _known_maps(self) -> dict[bytes, RetainMap]:
        try:
            rows = read_json(self._maps.load() or b"[]", longest=LONGEST_MAP, deepest=_DEEPEST)
            maps = [RetainMap.decode(typed(text, str).encode()) for text in items(rows, str, 2)]
        except MalformedError:
            return {}
        return {map.mark: map for map in maps}

    def _save(self, maps: dict[bytes, RetainMap]) -> None:
        try:
            self._maps.save(json.dumps([map.encode().decode() for map in maps.values()]).encode())
        except StoreError:
            return  # the flash disk is full or broken, and says so; the values last until the next boot


def _getter(addresses: Sequence[int]) -> Callable[[MutableSequence[Value]], tuple[Value, ...]]:
    """Return a function that reads the cells at some addresses."""
    if len(addresses) > 1:
        return itemgetter(*addresses)
    return lambda cells: tuple(cells[address] for address in addresses)


def _value(leaf: Leaf, markers: bytearray) -> Value:
    at, text = leaf.marker or 0, leaf.text
    if text is not None:
        return characters.decoded(bytes(markers[at : at + text.size]), is_wide=text.is_wide)
    if leaf.bit >= 0:
        return bool(markers[at] & 1 << leaf.bit)
    (value,) = struct.unpack_from("<" + leaf.code, markers, at)
    return value  # type: ignore[no-any-return]


def _put(leaf: Leaf, at: int, value: Value, markers: bytearray) -> None:
    if leaf.text is not None:
        struct.pack_into("<" + leaf.code, markers, at, characters.encoded(str(value), is_wide=leaf.text.is_wide))
    elif leaf.bit >= 0:
        markers[at] = markers[at] & ~(1 << leaf.bit) | bool(value) << leaf.bit
    else:
        struct.pack_into("<" + leaf.code, markers, at, value)
