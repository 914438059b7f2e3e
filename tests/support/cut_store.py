"""A store on which a process is killed while it saves."""

from fieldrig.storage.store import MemoryStore


class Killed(BaseException):
    """The process is gone."""


class CutStore(MemoryStore):
    """The number of saves that are allowed; the next one kills the process.  None sets no limit."""

    def __init__(self, data: bytes | None = None) -> None:
        super().__init__(data)
        self.allowed: int | None = None
        self.saves = 0

    def save(self, data: bytes) -> None:
        if self.saves == self.allowed:
            raise Killed
        self.saves += 1
        super().save(data)
