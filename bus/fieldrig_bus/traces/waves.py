"""The wires of a trace, each with its values and the instants at which they came.

A wire that carries a `Motion` has the value of each motion at its beginning, as the publisher sent it; between two of
them it keeps that value.  A wire that carries pulse trains or PWM is digital, and has all of their edges at their
instants; the last train of a trace is continued to its end, if that is not far.  Messages of other buses, and bytes
that are not a signal, have no waveform.
"""

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Final

from fieldrig.errors import UsageError
from fieldrig.traces.trace import TraceEntry, is_time_of_day
from fieldrig_bus.signals.codec import decode
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.wires import Signal, WiresFamily

Value = bool | int | float
Waveform = PulseTrain | Pwm
FAMILIES = frozenset({WiresFamily.family})
MOST_EDGES: Final = 20_000_000
"""Edges that are written or drawn at most."""
MOST_AFTER_THE_END: Final = 10_000
"""Pulses of the last train that are shown after the last message, at most."""


@dataclass(slots=True)
class Wave:
    """The values of one wire of one bus."""

    bus: str
    name: str
    unit: str
    changes: list[tuple[int, Value | Waveform]] = field(default_factory=list)
    """Instants in their order, and the values or waveforms from then on; several may come at the same instant."""

    @property
    def is_digital(self) -> bool:
        return all(isinstance(value, bool | Waveform) for _, value in self.changes)

    @property
    def is_whole(self) -> bool:
        """True if no value has a fraction."""
        return all(isinstance(_plain(value), int) for _, value in self.changes)

    def values(self, from_ns: int, until_ns: int) -> Iterator[tuple[int, Value]]:
        """Yield the value at `from_ns`, if there is one, and the changes after it up to and including `until_ns`."""
        is_digital = self.is_digital
        for number in range(max(bisect_right(self.changes, from_ns, key=_instant) - 1, 0), len(self.changes)):
            begin_ns, value = self.changes[number]
            if begin_ns > until_ns:
                return
            shown_ns = max(begin_ns, from_ns)
            if not is_digital or not isinstance(value, Waveform):
                yield shown_ns, _plain(value)
                continue
            end_ns = self._end_ns(number, until_ns)
            if end_ns > shown_ns:
                yield shown_ns, value.level_at(shown_ns)
                yield from value.edges(shown_ns + 1, end_ns)

    def edges_at_most(self, from_ns: int, until_ns: int) -> int:
        """Return how many changes `values` yields at most."""
        count = len(self.changes)
        for number, (begin_ns, value) in enumerate(self.changes):
            end_ns = self._end_ns(number, until_ns)
            if isinstance(value, Waveform) and end_ns > max(begin_ns, from_ns):
                count += 2 * (value.pulses_at(end_ns) - value.pulses_at(max(begin_ns, from_ns))) + 2
        return count

    def _end_ns(self, number: int, until_ns: int) -> int:
        """Return the instant at which a change is replaced by the next one, or the one after the last of interest."""
        return min(self.changes[number + 1][0], until_ns + 1) if number + 1 < len(self.changes) else until_ns + 1


@dataclass(slots=True)
class Waves:
    """The wires of a trace in the order of their first messages."""

    waves: list[Wave] = field(default_factory=list)
    origin_ns: int = 0
    """The instant from which times are counted: the start of a rig in virtual time, else the first message."""
    end_ns: int = 0
    """The instant of the last message on any bus, or of the end of a last train after it."""
    count: int = 0
    """Number of messages that are values of wires."""


def waves_of(entries: Iterable[TraceEntry]) -> Waves:
    """Return the wires of a trace.  Buses that were recorded side by side may be a little out of order."""
    first_ns: int | None = None
    waves = Waves()
    known: dict[tuple[str, str], Wave] = {}
    for entry in entries:
        first_ns = entry.time_ns if first_ns is None else min(first_ns, entry.time_ns)
        waves.end_ns = max(waves.end_ns, entry.time_ns)
        signal = _signal(entry)
        if signal is not None:
            wave = known.setdefault((entry.bus, signal.name), Wave(entry.bus, signal.name, signal.unit))
            wave.changes.append((entry.time_ns, signal if isinstance(signal, Waveform) else signal.value))
            waves.count += 1
    waves.waves = list(known.values())
    if first_ns is not None:
        waves.origin_ns = first_ns if is_time_of_day(first_ns) else min(first_ns, 0)
        _place(waves)
    for wave in waves.waves:
        wave.changes.sort(key=_instant)
        waves.end_ns = max(waves.end_ns, _last_ns(wave, waves.end_ns))
    return waves


def check_size(waves: Iterable[Wave], from_ns: int, until_ns: int) -> None:
    """Raise UsageError for waveforms with more edges than can be looked at."""
    edges = sum(wave.edges_at_most(from_ns, until_ns) for wave in waves)
    if edges > MOST_EDGES:
        raise UsageError(
            f"these wires have {edges} edges; expected at most {MOST_EDGES}", "choose fewer wires or a shorter time"
        )


def _place(waves: Waves) -> None:
    """Move the waveforms from the clock of their devices to that of the trace.

    In virtual time that is the same one.  In real time the trace counts from 1970.  A sender publishes a waveform when
    it begins, so the shortest time between a waveform's beginning and its message is the difference of the clocks.
    """
    for wave in waves.waves:
        lags = [time_ns - value.start_ns for time_ns, value in wave.changes if isinstance(value, Waveform)]
        if not lags:
            continue
        offset_ns = min(lags) if is_time_of_day(waves.origin_ns) else 0
        for number, (_, value) in enumerate(wave.changes):
            if isinstance(value, Waveform):
                moved = replace(value, start_ns=value.start_ns + offset_ns)
                wave.changes[number] = (max(moved.start_ns, waves.origin_ns), moved)


def _last_ns(wave: Wave, end_ns: int) -> int:
    """Return the end of the last train of a wire, if it is not far beyond the end of the trace."""
    _, last = wave.changes[-1]
    if not isinstance(last, PulseTrain) or last.count is None or last.end_ns is None:
        return end_ns
    return last.end_ns if last.count - last.pulses_at(end_ns) <= MOST_AFTER_THE_END else end_ns


def _instant(change: tuple[int, object]) -> int:
    return change[0]


def _plain(value: Value | Waveform) -> Value:
    return value.value if isinstance(value, Waveform) else value


def _signal(entry: TraceEntry) -> Signal | None:
    if entry.family not in FAMILIES:
        return None
    try:
        return decode(entry.data)
    except (ValueError, TypeError):
        return None
