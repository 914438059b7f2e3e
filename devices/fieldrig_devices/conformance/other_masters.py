"""Other masters on the bus: what they send to the node under test, whose verdicts are then not the node's alone.

An NMT command or an SDO request to the node that the suite has not sent comes from another master.  The masters that a
rig file names are kept from the node for the run: their commands are dropped, by the fault of the bus that any user can
add.  Their heartbeats are not, as a node that consumes one leaves 'operational' without it.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import product
from typing import Any, Final

from fieldrig.config.rig_file import RigConfig
from fieldrig.errors import ControlError, RigError, UsageError
from fieldrig.traces.names import members_of
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance.bench import ERROR_CONTROL, SDO_REQUEST
from fieldrig_devices.conformance.line import Seen

NMT_ID, SYNC_ID = 0x000, 0x080
ALL_NODES = 0
CLAIM: Final = "master of node-ID"

AddFault = Callable[[dict[str, Any]], int]
"""Adds a fault to the bus, and returns its number."""
ClearFault = Callable[[int], None]


def masters_of(config: RigConfig, bus: str, node_id: int) -> list[str]:
    """Return the devices at this bus that are masters of a node, and start it and write to it on their own."""
    return [
        member.entry.name
        for member in members_of(config, bus)
        if any(claim.value == node_id for claim in member.claims(CLAIM))
    ]


@contextmanager
def kept_off(masters: Sequence[str], node_id: int, add: AddFault, clear: ClearFault) -> Iterator[None]:
    """Drop the NMT commands, SYNC, SDO and guarding requests of these masters, until the end of the block.

    Raises UsageError if the bus cannot do that.
    """
    numbers: list[int] = []
    try:
        for master, identifier in product(masters, (NMT_ID, SYNC_ID, SDO_REQUEST + node_id, ERROR_CONTROL + node_id)):
            try:
                numbers.append(add({"what": "drop", "node": master, "identifier": identifier}))
            except (ControlError, RigError) as cause:
                raise UsageError(
                    f"{master} is the master of node {node_id} in this rig and would spoil the cases, and it cannot be"
                    f" kept from it: {cause}",
                    "test with --set time=virtual, take it out of the rig, or leave it at work by --with-masters",
                ) from cause
        yield
    finally:
        for number in numbers:
            clear(number)


def foreign(seen: Sequence[Seen], node_id: int) -> list[CanFrame]:
    """Return the frames by which another master commands this node or asks it."""
    return [each.frame for each in seen if not each.is_ours and _is_of_master(each.frame, node_id)]


def _is_of_master(frame: CanFrame, node_id: int) -> bool:
    if frame.is_remote or frame.is_extended:
        return False
    if frame.identifier == NMT_ID:
        return len(frame.data) == 2 and frame.data[1] in (ALL_NODES, node_id)
    return frame.identifier == SDO_REQUEST + node_id
