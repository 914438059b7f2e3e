"""The families of buses whose messages a replay compares."""

from typing import Final

from fieldrig_bus.ring.model import RING
from fieldrig_bus.telephone.model import EXCHANGE

OUTER: Final = frozenset({"can", "modbus", "serial"})
"""Families that a person can record at the outside of a machine: a rig that has no such bus is not as the machine."""
RINGS: Final = frozenset({"ring", "pamring"})
INNER: Final = RINGS | {"wires", "dualport", "telephone"}
"""Families inside of a machine.  Only the trace of a rig has them, so a rig made of another recording has none."""
MEDIA: Final = frozenset({RING, EXCHANGE})
"""Senders that are no device but the medium itself, for the answers of a ring and the tones of an exchange."""
COMPARED: Final = OUTER | INNER
"""The others (`tcp`, `ip`, `opcua`) carry connections of the host, which no log can open again."""
CYCLIC: Final = RINGS | {"can"}
"""Families on which timers send."""
