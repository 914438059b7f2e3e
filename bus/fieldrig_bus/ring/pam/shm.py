"""`pamring.shm`: the ring of a PAM in real time over shared memory (Linux)."""

from typing import ClassVar, Final

from fieldrig_bus.ring.pam.star_bus import PamRingStar, PamRingStarSettings
from fieldrig_bus.ring.transport.shm import ShmCarrier

MOST_BEHIND: Final = 1_000
"""Cycles that wait for a process that stands still: a node must not miss an order."""


class PamRingShm(PamRingStar):
    about: ClassVar[str] = "ring of a PAM with its nodes, in real time over shared memory (Linux)"

    def __init__(self, name: str, settings: PamRingStarSettings) -> None:
        super().__init__(name, settings)
        self.carrier = ShmCarrier(name, MOST_BEHIND)
