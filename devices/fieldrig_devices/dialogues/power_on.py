"""The instant of a log at which its rig is switched on: a machine that was on before needs a rig that runs before.

The same rule says, for a rig that is made of a recording, how long its devices have been on when the recording begins.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig.clock import S
from fieldrig.traces.trace import TraceEntry, is_time_of_day
from fieldrig_devices.canopen.names import ERROR_CONTROL, NODES, SDO_REQUEST, SDO_RESPONSE

HEAD: Final = 500
"""Messages at the beginning of a log that are looked at."""
SETTLE_NS: Final = S
"""Time for a rig to boot before a log begins that was recorded of a machine that was on already."""
BOOT_UP: Final = b"\x01\x00"
"""Length and data of a boot-up message (CiA 301, 7.2.8.3.2.1)."""
HEARTBEATS: Final = frozenset({b"\x01\x04", b"\x01\x05", b"\x01\x7f"})
"""Length and data of heartbeats: stopped, operational, pre-operational."""
TPDOS: Final = frozenset({0x180, 0x280, 0x380, 0x480})
"""The predefined identifiers of TPDOs, without the node-ID (CiA 301, 7.3.5)."""
SDO_SIZE: Final = 13
"""Bytes of an SDO request or answer in a trace."""


def rig_instant_ns(head: Sequence[TraceEntry]) -> int:
    """Return the instant of a log at which its rig is switched on; `head` has its first messages.

    That is 0 in a trace of virtual time, as it begins with its rig.  Elsewhere it is the first message, or a second
    before if nothing shows that the nodes boot.
    """
    first_ns = min((entry.time_ns for entry in head), default=0)
    if not is_time_of_day(first_ns) and (first_ns >= SETTLE_NS or not _was_on(head)):
        return 0
    return first_ns if any(map(is_boot_up, head)) else first_ns - SETTLE_NS


def _was_on(head: Sequence[TraceEntry]) -> bool:
    """Return whether the first message of a node is no boot-up, as a node that is switched on boots before."""
    for entry in head:
        if is_boot_up(entry):
            return False
        if entry.family == "can" and _is_of_node(entry):
            return True
    return False


def _is_of_node(entry: TraceEntry) -> bool:
    """Return whether only a node that has booted sends this frame: a heartbeat, an SDO answer, or a TPDO."""
    identifier = int.from_bytes(entry.data[:4], "little")
    base, node_id = identifier & ~0x7F, identifier & 0x7F
    if node_id not in NODES:
        return False
    if base == ERROR_CONTROL:
        return entry.data[4:] in HEARTBEATS
    if entry.sender:
        return False  # a trace of a rig, whose clock begins with it; a node of its own kind may have no boot-up
    return base in TPDOS or is_sdo_answer(entry)


def is_boot_up(entry: TraceEntry) -> bool:
    """Return whether a message is the boot-up of a node."""
    return _is_error_control(entry) and entry.data[4:] == BOOT_UP


def is_sdo_answer(entry: TraceEntry) -> bool:
    """Return whether a message answers an SDO, by its predefined identifier."""
    is_answer = entry.family == "can" and int.from_bytes(entry.data[:4], "little") - SDO_RESPONSE in NODES
    return is_answer and len(entry.data) == SDO_SIZE


def requested_node(entry: TraceEntry) -> int:
    """Return the node of an SDO request, by its predefined identifier; 0 for any other message."""
    node = int.from_bytes(entry.data[:4], "little") - SDO_REQUEST if entry.family == "can" else 0
    return node if node in NODES and len(entry.data) == SDO_SIZE else 0


def _is_error_control(entry: TraceEntry) -> bool:
    return entry.family == "can" and int.from_bytes(entry.data[:4], "little") - ERROR_CONTROL in NODES
