"""A store on which a process is killed while it saves."""

from fieldrig.store import MemoryStore


class Killed(BaseException):
    """The process is gone."""


class CutStore(MemoryStore):
    """The process is killed when it begins to save once more than it is allowed to; None: never."""

    def __init__(self, data: bytes | None = None) -> None:
        super().__init__(data)
        self.allowed: int | None = None
        self.saves = 0

    def save(self, data: bytes) -> None:
        if self.saves == self.allowed:
            raise Killed
        self.saves += 1
        super().save(data)
