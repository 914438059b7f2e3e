"""Base of all SERCOS rings: their messages as bytes and text, and the faults that they take."""

from collections.abc import Mapping
from typing import Any, ClassVar

from fieldrig.bus import Bus
from fieldrig_bus.ring.sercos import message
from fieldrig_bus.ring.sercos.faults import MODELS
from fieldrig_bus.ring.sercos.message import Answers, Cycle, Mdt, Mst, RingMessage


class SercosFamily(Bus[RingMessage]):
    """A SERCOS ring of any kind."""

    family: ClassVar[str] = "ring"
    notes_faults: ClassVar[bool] = True
    has_cycle: ClassVar[bool] = True
    messages: ClassVar[tuple[type, ...]] = (Mst, Mdt, Cycle, Answers, bytes)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    encode = staticmethod(message.encode)
    decode = staticmethod(message.decode)
    show = staticmethod(message.show)
    check = staticmethod(message.check_sent)
    check_interest = staticmethod(message.check_interest)
