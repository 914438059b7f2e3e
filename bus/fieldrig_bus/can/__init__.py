"""CAN: frames, the bus model, and what carries them."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "BitRate",
    "BusState",
    "CanControl",
    "CanError",
    "CanFrame",
    "CanMessage",
    "CanState",
    "ErrorKind",
    "FaultNote",
]

if TYPE_CHECKING:
    from fieldrig_bus.can.codec import CanMessage
    from fieldrig_bus.can.frame import CanFrame
    from fieldrig_bus.can.notices import BitRate, BusState, CanControl, CanError, CanState, ErrorKind, FaultNote
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_bus.can.codec": "CanMessage",
            "fieldrig_bus.can.frame": "CanFrame",
            "fieldrig_bus.can.notices": "BitRate BusState CanControl CanError CanState ErrorKind FaultNote",
        },
    )
