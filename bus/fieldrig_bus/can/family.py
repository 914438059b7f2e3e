"""Base of all CAN buses: their messages as bytes and text, and the checks of what members send and ask for."""

from typing import ClassVar

from fieldrig.bus import Bus
from fieldrig_bus.can import acceptance, codec
from fieldrig_bus.can.codec import CanMessage


class CanFamily(Bus[CanMessage]):
    """A CAN bus of any kind."""

    family: ClassVar[str] = "can"
    notes_faults: ClassVar[bool] = True

    encode = staticmethod(codec.encode)
    decode = staticmethod(codec.decode)
    show = staticmethod(codec.show)
    check = staticmethod(codec.check_sent)
    check_interest = staticmethod(acceptance.check_interest)
