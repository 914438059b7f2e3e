"""Memory for retain data over power-off: in the controller, on its flash disk by a UPS, or in a PN-4 module.

Source: PacDrive manual 6031-6034 (digest PD-048 to PD-050).  A capacitor supplies the 1 kByte of the controller and the
101 kByte of the module for 7 days; a battery supplies the module for longer.  With the object UPS, 64 kByte are written
to the flash disk at each power failure; after 100 000 write cycles it accepts no more (our reading).
"""

import logging
from typing import TYPE_CHECKING, Final, Literal

from fieldrig.storage.store import Store, StoreError
from fieldrig_devices.iec.limits import KB
from fieldrig_devices.max4.storage.disk import WRITE_CYCLES

if TYPE_CHECKING:
    from fieldrig_devices.max4.storage.buffered_ram import BufferedRam

log = logging.getLogger(__name__)

RetainKind = Literal["nvram", "ups", "pn4"]
SIZES: Final[dict[RetainKind, int]] = {"nvram": 1 * KB, "ups": 64 * KB, "pn4": 101 * KB}
_COUNT: Final = 4
"""Size of the write counter before the data on the disk, in bytes."""


class UpsMemory:
    """The copy of the retain data on the flash disk."""

    def __init__(self, ram: "BufferedRam", disk: Store) -> None:
        self._ram, self._disk = ram, disk

    @property
    def writes(self) -> int:
        """Number of write cycles so far."""
        return int.from_bytes((self._disk.load() or b"")[:_COUNT], "little")

    def save(self) -> None:
        """Save the retain data at a power failure, while the UPS supplies the controller."""
        writes = self.writes
        if writes >= WRITE_CYCLES:
            log.warning("retain data are not saved: the flash disk has reached its limit of %d write cycles", writes)
            return
        try:
            self._disk.save((writes + 1).to_bytes(_COUNT, "little") + self._ram.retained.copy())
        except StoreError as full:
            log.warning("retain data are not saved: %s", full.strerror)

    def restore(self) -> None:
        """Restore the retain data, if the disk has a copy of the right size."""
        kept = (self._disk.load() or b"")[_COUNT:]
        if kept:
            self._ram.retained.paste(kept)
