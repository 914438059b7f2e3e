"""Serial lines: bytes, control lines, baud rates."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "Break",
    "ControlLines",
    "Format",
    "SerialMessage",
]

if TYPE_CHECKING:
    from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_bus.serial.message": "Break ControlLines Format SerialMessage",
        },
    )
