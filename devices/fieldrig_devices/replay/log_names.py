"""The messages of a log by name, for comparisons: the namers of a rig, with the buses of the log."""

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

from fieldrig.bus import Bus
from fieldrig.cli.message_words import bus_of
from fieldrig.config.rig_file import RigConfig
from fieldrig.traces.names import Namer, in_words, namer_of
from fieldrig.traces.parts import HasParts, Parts
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.replay.streams import Item, Stream

SDO: Final = range(0x580, 0x680)
"""Identifiers of the default SDO channels (CiA 301, 7.3.5): they may change the mapping of PDOs."""


class _Known(NamedTuple):
    bus: Bus[Any]
    namer: Namer


class LogNames:
    """Names the messages of one log.  Without namers, messages are shown as their bus does."""

    def __init__(self, config: RigConfig | None = None) -> None:
        self._config = config
        self._known: dict[str, _Known | None] = {}

    @property
    def is_any(self) -> bool:
        """True if something has a name."""
        return self._config is not None

    def note(self, stream: Stream, item: Item) -> None:
        """Learn from a message what is mapped into PDOs."""
        if self._config is not None and stream.family == "can" and stream.key in SDO:
            known = self._of(item.entry)
            if known is not None:
                known.namer(known.bus.decode(item.entry.data), item.entry.sender)

    def parts(self, item: Item) -> Parts | None:
        """Return the values of a message; None if they are not known."""
        known = self._of(item.entry)
        if known is None or not isinstance(known.namer, HasParts):
            return None
        try:
            return known.namer.parts(known.bus.decode(item.entry.data), item.request)
        except ValueError:
            return None

    def words(self, entry: TraceEntry) -> str:
        """Return a message in one line."""
        known, plain = self._of(entry), bus_of(entry.family)
        try:
            if known is not None:
                return in_words(known.namer(known.bus.decode(entry.data), entry.sender))
            return entry.data.hex(" ") if plain is None else plain.show(plain.decode(entry.data))
        except ValueError:
            return entry.data.hex(" ")

    def _of(self, entry: TraceEntry) -> _Known | None:
        if self._config is None:
            return None
        if entry.bus not in self._known:
            name = bus_in(self._config, entry.bus, entry.family)
            self._known[entry.bus] = (
                None if name is None else _Known(self._config.buses[name].bus, namer_of(self._config, name))
            )
        return self._known[entry.bus]


def bus_in(config: RigConfig, bus: str, family: str, given: Mapping[str, str] | None = None) -> str | None:
    """Return the bus of a rig that a bus of a log is: that of the same name, or the only one of its family."""
    if given and bus in given:
        return given[bus]
    known = config.buses.get(bus)
    if known is not None and known.bus.family == family:
        return bus
    fitting = [name for name, entry in config.buses.items() if entry.bus.family == family]
    return fitting[0] if len(fitting) == 1 else None
