"""`can.virtual`: a CAN bus in virtual time.  `model` is the medium; `can.hub` runs the same one in real time.

Its addresses are where a master in a block of `virtual_time` connects, as it would to a `can.hub`.
"""

from typing import ClassVar

from fieldrig.bus import Time
from fieldrig_bus.can.outsiders import OutsidersBus, OutsidersSettings


class CanVirtual(OutsidersBus):
    about: ClassVar[str] = "CAN bus with arbitration and exact bit times, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})

    def __init__(self, name: str, settings: OutsidersSettings) -> None:
        super().__init__(name, settings)
