"""COB-IDs as parameters: an identifier with flags in the upper bits, and which changes of it are refused.

Source: CiA 301 7.5.2.5 (1005h), 7.5.2.17 (1014h), 7.5.2.33 (1200h), 7.5.2.35 (1400h), table 41 (restricted CAN-IDs).
"""

from collections.abc import Callable

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.variable import Variable

INVALID = 1 << 31
"""The service doesn't exist (SDO, PDO, EMCY)."""
BIT_30 = 1 << 30
"""No RTR allowed (TPDO); the device generates SYNC (1005h)."""
EXTENDED = 1 << 29

EXTENDED_KEY = 1 << 31
"""Marks 29-bit identifiers in the words of the CAN link's interest."""

# Table 41: never to be used by a configurable service.
RESTRICTED = (
    range(0x080),
    range(0x101, 0x181),
    range(0x581, 0x600),
    range(0x601, 0x680),
    range(0x6E0, 0x700),
    range(0x701, 0x800),
)


def can_key(cob_id: int) -> int:
    """The CAN identifier in a COB-ID, 29-bit ones marked with bit 31."""
    return cob_id & 0x1FFF_FFFF | EXTENDED_KEY if cob_id & EXTENDED else cob_id & 0x7FF


def is_restricted(cob_id: int) -> bool:
    return not cob_id & EXTENDED and any(cob_id & 0x7FF in ids for ids in RESTRICTED)


def is_well_formed(cob_id: int) -> bool:
    """Whether an 11-bit COB-ID leaves bits 11 to 28 at zero."""
    return bool(cob_id & EXTENDED) or not cob_id & 0x1FFF_F800


def is_valid(cob_id: int) -> bool:
    """Of the services whose bit 31 says that they don't exist."""
    return not cob_id & INVALID


def guard(variable: Variable, is_in_use: Callable[[int], bool] = is_valid, *, is_idle_checked: bool = False) -> None:
    """Let the network change a COB-ID only as the standard allows.

    While it `is_in_use`, bits 0 to 29 stay as they are.  A restricted or ill-formed identifier is not put in use,
    nor, with `is_idle_checked`, taken for later.
    """

    def write(data: bytes) -> None:
        old, new = variable.number, int.from_bytes(data, "little")
        if is_in_use(old) and is_in_use(new) and (old ^ new) & 0x3FFF_FFFF:
            raise Abort(Code.DEVICE_STATE)
        is_checked = new != old and (is_idle_checked or is_in_use(new))
        if is_checked and (is_restricted(new) or not is_well_formed(new)):
            raise Abort(Code.INVALID_VALUE)
        variable.set(data)

    variable.writer = write
