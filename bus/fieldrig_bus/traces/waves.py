"""The wires of a trace, each with its values and the instants at which they came.

A wire that carries a `Motion` has the value of each motion at its beginning, as the publisher sent it; between two of
them it keeps that value.  Messages of other buses, and bytes that are not a signal, have no waveform.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from fieldrig.trace import TraceEntry, is_time_of_day
from fieldrig_bus.wires import Signal, WiresFamily, decode

Value = bool | int | float
FAMILIES = frozenset({WiresFamily.family})


@dataclass(slots=True)
class Wave:
    """The values of one wire of one bus."""

    bus: str
    name: str
    unit: str
    changes: list[tuple[int, Value]] = field(default_factory=list)
    """Instants in their order, and the values from then on; several may come at the same instant."""

    @property
    def is_digital(self) -> bool:
        return all(isinstance(value, bool) for _, value in self.changes)

    @property
    def is_whole(self) -> bool:
        """True if no value has a fraction."""
        return all(isinstance(value, int) for _, value in self.changes)


@dataclass(slots=True)
class Waves:
    """The wires of a trace in the order of their first messages."""

    waves: list[Wave] = field(default_factory=list)
    origin_ns: int = 0
    """The instant from which times are counted: the start of a rig in virtual time, else the first message."""
    end_ns: int = 0
    """The instant of the last message on any bus."""
    count: int = 0
    """Number of messages that are values of wires."""


def waves_of(entries: Iterable[TraceEntry]) -> Waves:
    """Return the wires of a trace.  Buses that were recorded side by side may be a little out of order."""
    first_ns: int | None = None
    found = Waves()
    known: dict[tuple[str, str], Wave] = {}
    for entry in entries:
        first_ns = entry.time_ns if first_ns is None else min(first_ns, entry.time_ns)
        found.end_ns = max(found.end_ns, entry.time_ns)
        signal = _signal(entry)
        if signal is not None:
            wave = known.setdefault((entry.bus, signal.name), Wave(entry.bus, signal.name, signal.unit))
            wave.changes.append((entry.time_ns, signal.value))
            found.count += 1
    found.waves = list(known.values())
    for wave in found.waves:
        wave.changes.sort(key=lambda change: change[0])
    if first_ns is not None:
        found.origin_ns = first_ns if is_time_of_day(first_ns) else min(first_ns, 0)
    return found


def _signal(entry: TraceEntry) -> Signal | None:
    if entry.family not in FAMILIES:
        return None
    try:
        return decode(entry.data)
    except (ValueError, TypeError):
        return None
