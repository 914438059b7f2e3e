"""A hash of everything that has passed on the buses of a rig, to compare two rigs or two runs."""

import hashlib
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from fieldrig.bus import Bus, Delivery

BYTES: Final = 12
"""Enough that two different runs never have the same hash."""


class TraceHash:
    """Called with every delivery."""

    def __init__(self) -> None:
        self._hash, self._count = hashlib.blake2b(digest_size=BYTES), 0

    def __call__(self, bus: "Bus[Any]", delivery: "Delivery[Any]") -> None:
        self._count += 1
        said = (bus.name, delivery.time_ns, delivery.sender, bus.encode(delivery.message), delivery.receivers)
        self._hash.update(repr(said).encode())

    def text(self) -> str:
        """Return the number of messages and their hash."""
        return f"{self._count}:{self._hash.hexdigest()}"
