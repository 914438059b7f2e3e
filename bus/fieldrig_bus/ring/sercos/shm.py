"""`ring.shm`: the SERCOS ring in real time over shared memory, for short cycles with a process per drive (Linux)."""

from typing import ClassVar

from fieldrig_bus.ring.sercos.star import RingStarSettings
from fieldrig_bus.ring.sercos.star_bus import RingStar
from fieldrig_bus.ring.transport.shm_carrier import ShmCarrier


class RingShm(RingStar):
    about: ClassVar[str] = "SERCOS fibre ring, in real time over shared memory (Linux)"
    exchange_ns: ClassVar[int] = 30_000
    """Measured: 1.3 cores with 41 processes at 1 ms."""

    def __init__(self, name: str, settings: RingStarSettings) -> None:
        super().__init__(name, settings)
        self.carrier = ShmCarrier(name)
