"""The messages of a log by name, for comparisons: whole, and value by value."""

from collections.abc import Mapping
from contextlib import suppress
from typing import Final

from fieldrig.cli.message_words import bus_of
from fieldrig.config.rig_file import RigConfig
from fieldrig.traces.names import Namer, in_words
from fieldrig.traces.parts import HasParts, Parts
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.names import CanopenNames
from fieldrig_devices.dialogues.modbus_servers import plain_bus
from fieldrig_devices.named_logs.named_log import NamedLog, decoded
from fieldrig_devices.replay.streams import Item, Stream
from fieldrig_devices.sercos.names import SercosNames

SDO: Final = range(0x580, 0x680)
"""Identifiers of the default SDO channels (CiA 301, 7.3.5): they may change the mapping of PDOs."""


class LogNames:
    """Names the messages of one log, in their order: what is mapped into a PDO follows the SDO transfers of the log."""

    def __init__(self, named: NamedLog | None = None) -> None:
        self._named = named or NamedLog()
        self._namers: dict[tuple[str, str], Namer] = {}
        self._with_parts: dict[tuple[str, str], HasParts | None] = {}
        """The same, None for those that take nothing apart: asking a protocol takes longer than taking apart."""

    def note(self, stream: Stream, item: Item) -> None:
        """Learn from a message what is mapped into PDOs, and into the telegrams of a ring."""
        if stream.family == "can" and stream.key in SDO:
            with suppress(ValueError):  # a frame whose length lies
                self._namer(stream.bus, "can")(decoded(item.entry), item.entry.sender)
        elif stream.family == "ring":
            namer = self._namer(stream.bus, "ring")
            if isinstance(namer, SercosNames):
                with suppress(ValueError):
                    namer.note(decoded(item.entry))

    def parts(self, item: Item) -> Parts | None:
        """Return the values of a message; None if they are not known."""
        key = item.entry.bus, item.entry.family
        if key not in self._with_parts:
            namer = self._namer(*key)
            self._with_parts[key] = namer if isinstance(namer, HasParts) else None
        parted = self._with_parts[key]
        if parted is None:
            return None
        try:
            return parted.parts(decoded(item.entry), item.request)
        except ValueError:
            return None

    def node(self, bus: str, node_id: int) -> str:
        """Return the name of a node of a CAN bus, or `node 5`."""
        namer = self._namer(bus, "can")
        return namer.name(node_id) if isinstance(namer, CanopenNames) else f"node {node_id}"

    def dictionary(self, bus: str, node_id: int) -> Dictionary | None:
        """Return the object dictionary of a node of a CAN bus, as its EDS describes it; None without one."""
        namer = self._namer(bus, "can")
        return namer.dictionary(node_id) if isinstance(namer, CanopenNames) else None

    def prepare(self, bus: str, family: str) -> None:
        """Read the files and import what names the messages of a bus now, and not when the first of them comes."""
        bus_of(family)
        self._namer(bus, family)

    def words(self, entry: TraceEntry) -> str:
        """Return a message in one line."""
        plain = bus_of(entry.family)
        try:
            text = in_words(self._namer(entry.bus, entry.family)(decoded(entry), entry.sender))
            return text or (entry.data.hex(" ") if plain is None else plain.show(plain.decode(entry.data)))
        except ValueError:
            return entry.data.hex(" ")

    def _namer(self, bus: str, family: str) -> Namer:
        namer = self._namers.get((bus, family))
        if namer is None:
            namer = self._namers[bus, family] = self._named.namer(bus, family)
        return namer


def bus_in(config: RigConfig, bus: str, family: str, given: Mapping[str, str] | None = None) -> str | None:
    """Return the bus of a rig that a bus of a log is: that of the same name, or the only one of its family."""
    if given and bus in given:
        return given[bus]
    for name in (bus, plain_bus(bus)):  # a rig that is made of a recording has the plain name
        if name in config.buses and config.buses[name].bus.family == family:
            return name
    fitting = [name for name, entry in config.buses.items() if entry.bus.family == family]
    return fitting[0] if len(fitting) == 1 else None
