"""`can.virtual`: a CAN bus in virtual time.  `model` is the medium; `can.hub` runs the same one in real time."""

from typing import ClassVar

from fieldrig.bus import Time
from fieldrig_bus.can.model_bus import CanModelBus, CanSettings


class CanVirtual(CanModelBus):
    about: ClassVar[str] = "CAN bus with arbitration and exact bit times, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})

    def __init__(self, name: str, settings: CanSettings) -> None:
        super().__init__(name, settings)
