"""The buffered memory of a controller over power-off and power-on.

Source: PacDrive manual 4210-4214, 6031-6034 (digest PD-048 to PD-050, PD-111, PD-112).
"""

from fieldrig.storage.store import Store, StoreError
from fieldrig_devices.max4.storage.buffered_ram import RETENTION_DAYS, BufferedRam, ram_bytes
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.storage.retain import SIZES, RetainKind, UpsMemory


class Memory:
    """Buffered RAM, and the copy of its retain data on the flash disk if there is a UPS.

    While the store has no room for the RAM, log entries and retain data last only until the process ends.
    """

    def __init__(self, store: Store, disk: FlashDisk, retain: RetainKind, *, has_battery: bool) -> None:
        self._store, self._size = store, SIZES[retain]
        lasting = self._lasting_ram()
        self._is_lasting = lasting is not None
        ram = memoryview(bytearray(ram_bytes(self._size))) if lasting is None else lasting
        self.ram = BufferedRam(ram, self._size, has_battery=has_battery)
        self.ups = UpsMemory(self.ram, disk.section("RETAIN")) if retain == "ups" else None
        self._was_saved = False
        """True if the UPS has saved the retain data at the last power failure."""

    def power_on(self, off_days: float, *, is_lost: bool) -> bool:
        """Restore the memory after `off_days` without power, or lose it.  Return true if it is lost and reported."""
        was_saved, self._was_saved = self._was_saved, False
        if is_lost or off_days > RETENTION_DAYS:
            if self.ups is not None and not is_lost and not was_saved and self.ram.is_known:
                self.ram.retained.recover()
                self.ups.save()  # at the end of the process before this one, which may have been killed
            self.lose()
            return True
        if not self.ram.wake(off_days) and self.ups is not None:
            self.ups.restore()
        return False

    def power_off(self) -> None:
        """Save the retain data if there is a UPS."""
        if self.ups is not None:
            self.ups.save()
            self._was_saved = True

    def lose(self) -> None:
        """Lose the content of the RAM; a UPS restores the retain data."""
        self.ram.lose()
        if self.ups is not None:
            self.ups.restore()

    def move_to_store(self) -> None:
        """Move the RAM to the store if the store had no room for it before and has room now."""
        if not self._is_lasting and (ram := self._lasting_ram()) is not None:
            self._is_lasting = True
            self.ram.move_to(ram)

    def _lasting_ram(self) -> memoryview | None:
        """RAM in the store, or None if the store has no room for it."""
        try:
            return self._store.buffered_ram(ram_bytes(self._size))
        except StoreError:
            return None
