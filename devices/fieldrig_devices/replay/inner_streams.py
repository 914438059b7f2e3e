"""The streams of what is inside of a machine: wires by name, and the telegrams of rings by direction.

A message is compared without what belongs to its own log: the number of a cycle, and the instants in a signal that
moves by itself.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Final

from fieldrig.faults import note
from fieldrig_bus.signals import traced
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.signals.signal import Motion

Placed = tuple[str, bytes]
"""The key of a stream, and the content of the message that is compared."""

SERCOS: Final = {0: "MDT", 1: "AT", 2: "AT", 3: "MST", 4: "MDT"}
"""Streams by the first byte of a message of a SERCOS ring; its number is the next four bytes of the first two."""
NUMBERED: Final = (0, 1, 3)
PAM: Final = {0: "orders", 1: "orders", 2: "reports", 3: "reports"}
"""Streams by the second byte of a message of a PAM's ring; the number of the cycle is the next four bytes."""


def wires(data: bytes) -> Placed | None:
    """Return a signal without the instants in it, which are of the clock of its own log."""
    try:
        message = traced.decode(data)
    except ValueError:
        return None
    return getattr(message, "name", "faults"), _timeless(message, data)


def _timeless(message: Any, data: bytes) -> bytes:
    match message:
        case Motion():
            return traced.encode(replace(message, time_ns=0))
        case PulseTrain():
            return traced.encode(replace(message, start_ns=0, epoch_ns=0))
        case Pwm():
            return traced.encode(replace(message, start_ns=0))
    return data


def sercos(data: bytes) -> Placed | None:
    """Return a message of a SERCOS ring without the number of its cycle."""
    key = SERCOS.get(data[0]) if data else None
    if key is None:
        return None
    return key, data[:1] + data[5:] if data[0] in NUMBERED else data


def pam(data: bytes) -> Placed | None:
    """Return a message of a PAM's ring without the number of its cycle."""
    if len(data) < 2 or data.startswith(note.LEAD) or data[1] not in PAM:
        return None
    return PAM[data[1]], data[:2] + data[6:]


PLACES: Final[Mapping[str, Callable[[bytes], Placed | None]]] = {"wires": wires, "ring": sercos, "pamring": pam}
"""Returns the stream and the content of a message by family; None for one that is not of the family's form."""
