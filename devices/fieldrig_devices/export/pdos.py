"""The PDOs of a node as messages, by the communication and mapping parameters that it has at power-on.

Source: CiA 301 version 4.2, 7.2.2 (PDO and MPDO) and 7.5.2.35 to 7.5.2.38 (parameters).
"""

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

from fieldrig_devices.canopen.cob_id import EXTENDED, is_valid
from fieldrig_devices.canopen.pdo.mapping import MAX_ENTRIES, Mode
from fieldrig_devices.canopen.pdo_maps import MOST, RPDO, TO_MAPPING, TPDO
from fieldrig_devices.export.network import MOST_BITS, Message, Signal, with_unique_names
from fieldrig_devices.export.objects import Objects

EVENT_DRIVEN: Final = 254
"""The transmission types from here on are those of events, with a timer."""
WHOLE: Final = 8
LAST_SYNC: Final = 240
"""The highest transmission type that a SYNC acts on."""


class Kind(NamedTuple):
    first: int
    word: str


SENT, RECEIVED = Kind(TPDO, "TPDO"), Kind(RPDO, "RPDO")


def pdos(kind: Kind, node: str, objects: Objects, other: str) -> Iterator[Message]:
    """Yield the PDOs of one kind that exist; `other` is the node at their other end."""
    dictionary = objects.dictionary
    for index in dictionary.indices(kind.first, kind.first + MOST - 1):
        cob_id = dictionary.number(index, 1)
        number = index - kind.first + 1
        identifier = cob_id & (0x1FFF_FFFF if cob_id & EXTENDED else 0x7FF)
        if not is_valid(cob_id) or not identifier:
            continue
        signals, length = _content(objects, index + TO_MAPPING)
        is_sent = kind is SENT
        yield Message(
            identifier,
            f"{node}_{kind.word}{number}",
            length,
            signals,
            node if is_sent else other,
            () if is_sent else (node,),
            f"{kind.word} {number} of {node}, {_when(kind, dictionary.number(index, 2))}",
            bool(cob_id & EXTENDED),
            _period_ms(objects, index) if is_sent else None,
        )


def _when(kind: Kind, transmission: int) -> str:
    """Return in words when a PDO is sent or acts, by its transmission type (7.5.2.35, 7.5.2.37)."""
    if kind is RECEIVED:
        return "acts at the next SYNC" if transmission <= LAST_SYNC else "acts at once"
    match transmission:
        case 0:
            return "sent with SYNC after an event"
        case 1:
            return "sent with each SYNC"
        case _ if transmission <= LAST_SYNC:
            return f"sent with each SYNC of {transmission}"
        case 252 | 253:
            return "sent on request"
    return "sent after an event"


def _content(objects: Objects, mapping: int) -> tuple[Sequence[Signal], int]:
    """Return the signals, and the length in bytes; one whose mapping a master writes later can be of any length."""
    entries = objects.dictionary.number(mapping, 0)
    if entries in (Mode.SOURCE.value, Mode.DESTINATION.value):
        return _multiplexed(), WHOLE
    found, at = list[Signal](), 0
    for subindex in range(1, entries + 1 if entries <= MAX_ENTRIES else 1):
        entry = objects.dictionary.number(mapping, subindex)
        length = entry & 0xFF
        if at + length > MOST_BITS:
            break
        if length:  # an EDS of a careless maker maps nothing in one of its entries
            found += objects.signals(entry >> 16, entry >> 8 & 0xFF, at, length)
        at += length
    return tuple(with_unique_names(found)), (at + 7) // 8 or WHOLE


def _multiplexed() -> Sequence[Signal]:
    """Return what an MPDO says of itself: the node, the object and its value."""
    return (
        Signal("node", 0, 7, about="address of the node, 0 for all"),
        Signal("is_destination", 7, 1, choices={0: "source", 1: "destination"}),
        Signal("object_index", 8, 16),
        Signal("object_subindex", 24, 8),
        Signal("object_value", 32, 32),
    )


def _period_ms(objects: Objects, index: int) -> int | None:
    timer = objects.dictionary.number(index, 5)
    return timer if timer and objects.dictionary.number(index, 2) >= EVENT_DRIVEN else None
