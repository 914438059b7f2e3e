"""Base of the rings of a PAM: their messages as bytes and text, and the faults that they take."""

from collections.abc import Mapping
from typing import Any, ClassVar

from fieldrig.bus import Bus
from fieldrig_bus.ring.pam import message
from fieldrig_bus.ring.pam.faults import MODELS
from fieldrig_bus.ring.pam.message import Cycle, Frames, Reports, RingMessage


class PamRingFamily(Bus[RingMessage]):
    """A PAM's ring of any kind."""

    family: ClassVar[str] = "pamring"
    notes_faults: ClassVar[bool] = True
    has_cycle: ClassVar[bool] = True
    messages: ClassVar[tuple[type, ...]] = (Frames, Cycle, Reports, bytes)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    encode = staticmethod(message.encode)
    decode = staticmethod(message.decode)
    show = staticmethod(message.show)
    check = staticmethod(message.check_sent)
    check_interest = staticmethod(message.check_interest)
