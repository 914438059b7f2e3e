"""COB-IDs as parameters: an identifier with flags in the upper bits, and the rules for changing it.

Source: CiA 301 7.5.2.5 (1005h), 7.5.2.17 (1014h), 7.5.2.33 (1200h), 7.5.2.35 (1400h), table 41 (restricted CAN-IDs).
"""

from collections.abc import Callable

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.variable import Variable

INVALID = 1 << 31
"""Set if the service doesn't exist (SDO, PDO, EMCY)."""
BIT_30 = 1 << 30
"""Set if RTR is not allowed (TPDO), or if the device produces SYNC (1005h)."""
EXTENDED = 1 << 29

EXTENDED_KEY = 1 << 31
"""Marks 29-bit identifiers in the `interest` of the CAN link."""

# CAN-IDs that no configurable service may use (table 41).
RESTRICTED = (
    range(0x080),
    range(0x101, 0x181),
    range(0x581, 0x600),
    range(0x601, 0x680),
    range(0x6E0, 0x700),
    range(0x701, 0x800),
)


def can_key(cob_id: int) -> int:
    """Return the CAN identifier in a COB-ID; bit 31 marks a 29-bit identifier."""
    return cob_id & 0x1FFF_FFFF | EXTENDED_KEY if cob_id & EXTENDED else cob_id & 0x7FF


def is_restricted(cob_id: int) -> bool:
    return not cob_id & EXTENDED and any(cob_id & 0x7FF in ids for ids in RESTRICTED)


def is_well_formed(cob_id: int) -> bool:
    """True if bits 11 to 28 of an 11-bit COB-ID are zero."""
    return bool(cob_id & EXTENDED) or not cob_id & 0x1FFF_F800


def is_valid(cob_id: int) -> bool:
    """True if the service of this COB-ID exists, for the services that bit 31 switches off."""
    return not cob_id & INVALID


def guard(variable: Variable, is_in_use: Callable[[int], bool] = is_valid, *, is_idle_checked: bool = False) -> None:
    """Let the network change a COB-ID only as the standard allows.

    While the COB-ID `is_in_use`, bits 0 to 29 cannot change.  A restricted or malformed identifier cannot be put into
    use; with `is_idle_checked` it is refused even while it is not in use.
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
