"""Messages of a PAM about its ring (sections 14.3 to 14.6 of the digest of the system).

The form is that of `Kernel.report`: origin, two dots, type and number.
"""

from typing import Final

from fieldrig_devices.pamring.frames import Severity, Trouble

Message = tuple[str, tuple[int, ...]]
"""A code with its details D1, D2 and D3."""

LARGEST_NUMBER: Final = 0xFFF
"""The number of a message has three hexadecimal digits (table 12-6)."""
RING_MODE: Final = 1
"""D1 of the errors of the ring's configuration, for Socapel's usage; indexed mode is our only one."""
FIFO_ADDRESS: Final = 0
"""D1 of `OVERLOADED`, for Socapel's usage."""

NOT_INITIALISED: Final = "06..F001"
UNDECLARED_NODE: Final = "06..F002"
NODE_MISSING: Final = "06..F003"
WRONG_TYPE: Final = "06..F004"
NODE_NOT_READY: Final = "06..F005"
WRONG_COUNT: Final = "06..F006"
OVERLOADED: Final = "06..F009"
NOTHING_RECEIVED: Final = "06..F00C"
CRC_ERROR: Final = "06..F00E"
LINK_INTERRUPTED: Final = "06..F010"
TOO_MANY_NODES: Final = "06..F016"

RING_FIFO_FULL: Final = "07..E006"
BAD_ACKNOWLEDGE: Final = "07..E00B"
RING_IN_ERROR: Final = "07..E013"
CONFIGURATION_ERROR: Final = "07..F014"
INITIALISATION_REFUSED: Final = "07..F015"
CONFIGURATION_UNANSWERED: Final = "07..F016"
RUN_UNANSWERED: Final = "07..F017"
AXIS_REFUSED: Final = "07..F01F"
READ_TIMEOUT: Final = "07..E021"
NODE_WITHOUT_ITEMS: Final = "07..F025"
BAD_ST1_ITEM: Final = "07..F02D"

EMPTY_RING_CHECKED: Final = "07..M003"
RING_CHECKED: Final = "07..M004"
NODES_READY: Final = "07..M00B"
READY_WITHOUT_NODES: Final = "07..M00C"
SMART_IO_CONFIGURED: Final = "07..M00D"
INPUTS_RECEIVED: Final = "07..M00E"
SMART_IO_RUNNING: Final = "07..M013"
ST1_IO_CONFIGURED: Final = "07..M014"

ITEM_REFUSED: Final = "04..E01A"

NODE_INIT_ERROR: Final = "NODE INIT. ERROR"
ALL_NODES_INACTIVE: Final = "ALL NODES WITHOUT ACTIVE ITEM"

UNALLOWED_COMMAND: Final = 0x0A
"""D2 of 04..W00C when a node refuses a command in its present state."""

_TYPES: Final = {Severity.WARNING: "W", Severity.ENDED: "K", Severity.ERROR: "E"}


def plain(code: str) -> Message:
    """A message whose details are 0."""
    return code, (0, 0, 0)


def of_trouble(address: int, trouble: Trouble) -> Message:
    """The message of a node, as the PAM shows it: with three digits, whatever the node has sent."""
    return f"04..{_TYPES[trouble.severity]}{trouble.code & LARGEST_NUMBER:03X}", (address, *trouble.details)
