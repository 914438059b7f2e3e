"""Where retain data are kept over power-off: in the controller, on its flash disk by a UPS, or in a PN-4 module.

Source: PacDrive manual 6031-6034 (digest PD-048 to PD-050).  The controller's own 1 kByte and the module's 101 kByte
live off a capacitor for 7 days, the module's longer with a battery.  With the object UPS 64 kByte are written to the
flash disk when the power goes, each time one of its 100 000 write cycles; it takes no more after them (our reading).
"""

import logging
from typing import TYPE_CHECKING, Final, Literal

from fieldrig.store import Store, StoreError

if TYPE_CHECKING:
    from fieldrig_devices.max4.storage.buffered_ram import BufferedRam

log = logging.getLogger(__name__)

RetainKind = Literal["nvram", "ups", "pn4"]
KB: Final = 1024
SIZES: Final[dict[RetainKind, int]] = {"nvram": 1 * KB, "ups": 64 * KB, "pn4": 101 * KB}
WRITE_CYCLES: Final = 100_000
_COUNT: Final = 4
"""Bytes before the data on the disk: how often they have been written."""


class UpsMemory:
    """The flash disk's copy of the retain data."""

    def __init__(self, ram: "BufferedRam", disk: Store) -> None:
        self._ram, self._disk = ram, disk

    @property
    def writes(self) -> int:
        return int.from_bytes((self._disk.load() or b"")[:_COUNT], "little")

    def save(self) -> None:
        """The power goes, and the UPS gives the time for it."""
        writes = self.writes
        if writes >= WRITE_CYCLES:
            log.warning("the flash disk has been written %d times, and takes no more retain data", writes)
            return
        try:
            self._disk.save((writes + 1).to_bytes(_COUNT, "little") + bytes(self._ram.nvram))
        except StoreError as full:
            log.warning("retain data were not kept: %s", full.strerror)

    def restore(self) -> None:
        kept = (self._disk.load() or b"")[_COUNT:]
        if len(kept) == len(self._ram.nvram):
            self._ram.nvram[:] = kept
