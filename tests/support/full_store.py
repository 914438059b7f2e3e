"""A store on a disk without room."""

from errno import ENOSPC

from fieldrig.storage.store import MemoryStore, StoreError


class FullStore(MemoryStore):
    """Takes nothing while it is full; buffered RAM that it has given stays."""

    def __init__(self, data: bytes | None = None) -> None:
        super().__init__(data)
        self.is_full = True
        self.has_ram = True
        self.refused = 0

    def save(self, data: bytes) -> None:
        if self.is_full:
            self.refused += 1
            raise StoreError(ENOSPC, "No space left on device")
        super().save(data)

    def buffered_ram(self, size: int) -> memoryview:
        if not self.has_ram:
            raise StoreError(ENOSPC, "No space left on device")
        return super().buffered_ram(size)
