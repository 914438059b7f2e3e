"""The area of a dictionary that the objects of drives have, and the device type of a drive.

Source: CiA 402-2 (IEC 61800-7-201): the objects of the n-th axis are 800h further on than those of the first one.
"""

from typing import Final

PROFILE: Final = 402
AXIS_STEP: Final = 0x800
_AREA: Final = range(0x6000, 0xA000)


def is_drive_type(device_type: int) -> bool:
    """True for a device type (1000h) with the profile of drives in its lower word."""
    return device_type & 0xFFFF == PROFILE


def of_first_axis(index: int) -> int | None:
    """Return the index of the same object of the first axis; None for one of another area."""
    return _AREA.start + (index - _AREA.start) % AXIS_STEP if index in _AREA else None
