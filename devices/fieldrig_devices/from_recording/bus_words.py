"""The messages of a CAN bus of a recording that belong to no device, in sentences."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Final

from fieldrig.points.values import counted
from fieldrig.text.ranges import ranges
from fieldrig.traces.instants import span
from fieldrig_devices.canopen.cob_id import BIT_30
from fieldrig_devices.canopen.nmt import NMT_ID
from fieldrig_devices.from_recording.can_log import SYNC_ID, TIME_ID, CanLog, NodeLog

SYNC_COB_ID: Final = 0x1005
SYNC_OVERFLOW: Final = 0x1019
SERVICES: Final = frozenset({NMT_ID, SYNC_ID, TIME_ID, 0x7E4, 0x7E5})
"""Identifiers of services without a node: NMT, SYNC, TIME, LSS."""
OF_NODES: Final = (0x080, 0x580, 0x600, 0x700)
"""Identifiers of EMCY, SDO and error control, without the node-ID."""
MOST_NAMED: Final = 12


def left_over(log: CanLog, rest: Mapping[int, int], devices: Collection[int]) -> Iterator[str]:
    """Yield what belongs to no device; `rest` are identifiers with their counts, `devices` the node-IDs."""
    strange = {
        identifier: count
        for identifier, count in rest.items()
        if not (log.is_canopen and identifier in SERVICES)
        and not (identifier & 0x780 in OF_NODES and identifier & 0x7F in log.nodes)
    }
    if strange:
        words = [f"{identifier:03X}h ({counted(count, 'frame')})" for identifier, count in strange.items()]
        yield f"identifiers that no node accounts for: {_some(words)}"
    yield from _other_frames(log)
    yield from _silent({node_id: node for node_id, node in log.nodes.items() if node_id not in devices})
    has_producer = any((node.objects.number(SYNC_COB_ID) or 0) & BIT_30 for node in log.nodes.values())
    if log.sync_ns and not has_producer:
        yield f"SYNC every {span(log.sync_ns)}: no device here sends it, so your master has to"


def _other_frames(log: CanLog) -> Iterator[str]:
    if log.extended:
        total = sum(log.extended.values()) + log.other_extended
        words = [f"{identifier:08X}h" for identifier in log.extended]
        kind = "another protocol beside CANopen" if log.is_canopen else "J1939 or another protocol"
        yield f"{counted(total, 'frame')} with identifiers of 29 bits, as {kind} has them: {_some(words)}; left out"
    if log.fd:
        yield f"{counted(log.fd, 'frame')} of CAN FD, which CANopen does not have; left out"
    if log.notices:
        yield f"{counted(log.notices, 'report')} of bus errors; a rig has them by `fieldrig fault`"
    if log.unreadable:
        yield f"{counted(log.unreadable, 'message')} that cannot be read; left out"


def _silent(nodes: Mapping[int, NodeLog]) -> Iterator[str]:
    """Yield the nodes that never answered; those that were asked alike are one sentence, as a master may ask all."""
    asked: dict[str, list[int]] = {}
    for node_id, node in sorted(nodes.items()):
        if words := ", ".join(_asked(node)):
            asked.setdefault(words, []).append(node_id)
    for words, alike in asked.items():
        yield never_answered("node", alike, words)


def never_answered(word: str, numbers: Sequence[int], asked: str) -> str:
    """Return the sentence about nodes or units that never answered, each as much as `asked` says."""
    if len(numbers) == 1:
        return f"{word} {numbers[0]} never answered {asked}: it is no device here"
    return f"{word}s {ranges(numbers)} never answered {asked} each: they are no devices here"


def _asked(node: NodeLog) -> Iterator[str]:
    if node.objects.unanswered:
        yield counted(node.objects.unanswered, "SDO request")
    if node.life.guarded:
        yield counted(len(node.life.guarded), "guarding request")


def _some(words: list[str]) -> str:
    more = len(words) - MOST_NAMED
    return ", ".join(words[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
