"""The bit of the error register (1001h) that belongs to an error code of CiA 402.

Source: CiA 301 7.5.2.2 (bits), CiA 402-2, annex 'error codes' (their first digits).
"""

from typing import Final

from fieldrig_devices.canopen.emcy import COMMUNICATION

_REGISTER: Final = {0x2: 0x02, 0x3: 0x04, 0x4: 0x08, 0xF: 0x80}
"""Bits for current, voltage, temperature and the maker's errors, by the first digit of the error code."""
_PROFILE: Final = 0x20


def register_of(error: int) -> int:
    """Return the bit of the error register for an error code."""
    if error >> 8 in (0x75, 0x81):
        return COMMUNICATION
    return _REGISTER.get(error >> 12, _PROFILE)
