"""Objects with special rules, for which generic tests of reading, writing and comparing are meaningless.

Source: CiA 301 7.5.2, CiA 302-3 (1F50h).
"""

from collections.abc import Iterable

from fieldrig_devices.conformance.description import DOMAIN, LAST_OF_COMMUNICATION, Entry

RPDO, RPDO_MAPPING, TPDO, TPDO_MAPPING = (
    range(0x1400, 0x1600),
    range(0x1600, 0x1800),
    range(0x1800, 0x1A00),
    range(0x1A00, 0x1C00),
)
COMMANDS: tuple[Iterable[int], ...] = ((0x1003, 0x1010, 0x1011), range(0x1023, 0x1027), range(0x1F50, 0x1F58))
"""Objects that trigger an action when written: error history, storing, OS commands, program download."""
LIVE = (0x1001, 0x1002, 0x1003, 0x1010, 0x1011, 0x1012, 0x1013, 0x1020)
"""Objects that change by themselves: errors, capabilities, time, the configuration date."""
ACTUAL = (
    0x603F, 0x6041, 0x6043, 0x6044, 0x6061, 0x6062, 0x6063, 0x6064, 0x6069, 0x606B, 0x606C, 0x6074, 0x6077, 0x6078,
    0x6079, *range(0x60B9, 0x60BE), *range(0x60D1, 0x60D9), 0x60F4, 0x60FA, 0x60FC, 0x60FD,
)  # fmt: skip
"""Actual values of a drive (CiA 402-2), which some files do not let be mapped."""
SERIAL_NUMBER = (0x1018, 4)
COB_IDS = ((0x1005, 0), (0x1012, 0), (0x1014, 0))
"""Identifiers of SYNC, TIME and EMCY; those of PDOs and SDOs are in their communication parameters."""
SDO_PARAMETERS = range(0x1200, 0x1300)
INHIBIT_TIME, SYNC_START = 3, 6
"""Sub-indices of PDO communication parameters that may not be written while the PDO is valid."""


def is_command(entry: Entry) -> bool:
    return any(entry.index in indices for indices in COMMANDS) or entry.type == DOMAIN


def is_guarded(entry: Entry) -> bool:
    """True if an object may be written only as part of a procedure."""
    if entry.index in RPDO_MAPPING or entry.index in TPDO_MAPPING:
        return True
    return (entry.index in RPDO or entry.index in TPDO) and entry.sub in (INHIBIT_TIME, SYNC_START)


def is_identifier(entry: Entry) -> bool:
    """True for a COB-ID, whose identifier may not change while the service exists (CiA 301, 7.5.2.5 and others)."""
    if entry.index in RPDO or entry.index in TPDO:
        return entry.sub == 1
    return (entry.index, entry.sub) in COB_IDS or (entry.index in SDO_PARAMETERS and entry.sub in (1, 2))


def is_plain(entry: Entry) -> bool:
    """True if the present value can be written back at any time, provided that the object is writable."""
    return entry.is_readable and not is_command(entry) and not is_guarded(entry)


def is_live(entry: Entry) -> bool:
    """True if the value may differ from the default without having been written."""
    is_input = entry.is_mappable and entry.access in ("ro", "rwr") and entry.index > LAST_OF_COMMUNICATION
    is_actual = entry.access == "ro" and entry.index in ACTUAL
    return (
        is_input
        or is_actual
        or entry.index in LIVE
        or (entry.index, entry.sub) == SERIAL_NUMBER
        or entry.type == DOMAIN
    )
