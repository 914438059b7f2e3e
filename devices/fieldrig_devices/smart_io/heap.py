"""The memory of the node for its items, which is limited: F 3 (Appendix F).

The manual gives no sizes.  Ours are such that a keyboard and 16 modules fit with an item for each of their inputs and
outputs, and with eight DC motors.
"""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.pamring.frames import (
    AnalogItem,
    Configuration,
    CounterItem,
    InputItem,
    KeyItem,
    LedItem,
    MotorItem,
    OutputItem,
    SevenSegmentItem,
)

HEAP_BYTES: Final = 24 * 1024
_SIZES: Final[Mapping[type[object], int]] = {
    CounterItem: 48,
    KeyItem: 48,
    AnalogItem: 16,
    LedItem: 24,
    SevenSegmentItem: 24,
    MotorItem: 160,
}
_INPUT, _INPUT_BIT, _OUTPUT, _OUTPUT_BIT = 32, 16, 16, 8


def size_of(item: Configuration) -> int:
    """Return the bytes that an item occupies."""
    match item:
        case InputItem():
            return _INPUT + _INPUT_BIT * item.bits
        case OutputItem():
            return _OUTPUT + _OUTPUT_BIT * item.bits
    return _SIZES.get(type(item), 0)
