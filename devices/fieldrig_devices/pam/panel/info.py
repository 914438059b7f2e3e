"""The information of the fatal error panel beside the code of an error (tables 12-7 to 12-12, PAMS-060)."""

from collections.abc import Mapping, Sequence
from typing import Final

from fieldrig_devices.pam.panel.codes import Code

NO_INFO: Final = 0
NODE_ADDRESS: Final = 1
PERIPHERAL_NUMBER: Final = 2
_RING: Final = 6
_ADDRESS_IN_D2: Final = (0x002, 0x003, 0x004, 0x005, 0x007, 0x008, 0x009, 0x016)
_NUMBER_IN_D2: Final = (0x006, 0x022)
_TAGS: Final[Mapping[int, int]] = dict.fromkeys(_ADDRESS_IN_D2, NODE_ADDRESS) | dict.fromkeys(
    _NUMBER_IN_D2, PERIPHERAL_NUMBER
)


def is_in_the_table_of_the_ring(code: Code) -> bool:
    """True for the fatal errors of table 12-7, which are the cause of others that follow."""
    return code.is_fatal and code.origin == _RING and code.number in _TAGS


def panel_info(code: Code, details: Sequence[int | float]) -> tuple[int, int]:
    """Return the tag of the panel and its first information: a node or a number of peripherals, which are D2."""
    tag = _TAGS.get(code.number, NO_INFO) if code.origin == _RING else NO_INFO
    return (tag, int(details[1])) if tag and len(details) > 1 else (NO_INFO, 0)
