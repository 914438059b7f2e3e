"""The scan of input flags: the whole area once per PERIOD, a slice of it in each basic cycle (PAMS-090)."""

from collections.abc import Iterable, Iterator

from fieldrig_devices.pam.ports.memory import Memory
from fieldrig_devices.pam.ports.simatic.cells import Place
from fieldrig_devices.pam.ports.variables import PortItem


class Scan:
    """The area reaches from the lowest to the highest cell with an input flag, whatever is between them."""

    def __init__(self, memory: Memory, flags: Iterable[tuple[Place, PortItem]], period: int) -> None:
        self._words, self._period = memory.words, period
        self._flags: dict[int, list[tuple[int, PortItem]]] = {}
        for place, item in flags:
            self._flags.setdefault(place.cell, []).append((place.mask, item))
        first, last = (min(self._flags), max(self._flags)) if self._flags else (0, -1)
        self._seen = dict.fromkeys(range(first, last + 1), 0)
        self.size = -(-len(self._seen) // period)
        """Cells that are read in one basic cycle."""
        cells = list(self._seen)
        self._slices = [cells[at * self.size : (at + 1) * self.size] for at in range(period)]

    def changes(self, cycle_number: int) -> Iterator[tuple[PortItem, bool]]:
        """Read the slice of this basic cycle, and yield its flags in the cells that have changed."""
        for cell in self._slices[cycle_number % self._period]:
            word = self._words[cell]
            if word != self._seen[cell]:
                self._seen[cell] = word
                for mask, item in self._flags.get(cell, ()):
                    yield item, bool(word & mask)

    def all(self) -> Iterator[tuple[PortItem, bool]]:
        """Read the whole area, and yield all flags."""
        for cell, flags in self._flags.items():
            self._seen[cell] = word = self._words[cell]
            for mask, item in flags:
                yield item, bool(word & mask)
