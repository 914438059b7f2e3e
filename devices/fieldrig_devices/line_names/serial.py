"""The messages of a serial line by name: bytes by the protocol that they carry, control lines, formats and breaks."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from fieldrig.bus import Bus
from fieldrig.traces.names import Member, Named, Namer
from fieldrig_bus.serial.codec import show
from fieldrig_bus.serial.message import Break, ControlLines, Format
from fieldrig_devices.line_names.characters import text_or_hex
from fieldrig_devices.line_names.described import HasLines, LineReader
from fieldrig_devices.line_names.text_line import TextLine

KINDS: Final[Mapping[type[Any], str]] = {ControlLines: "control lines", Format: "format", Break: "break"}


class SerialNames:
    """Names the messages of one line."""

    def __init__(self, devices: Sequence[str], reader: LineReader) -> None:
        """`devices` are those at the line, by their names in the rig."""
        self._devices, self._reader = devices, reader

    def __call__(self, message: Any, sender: str = "") -> Named:
        if not isinstance(message, bytes):
            kind = KINDS.get(type(message))
            return Named("fault", sender, show(message)) if kind is None else Named(kind, sender, show(message))
        parts = self._reader(sender, message)
        if not parts:
            return Named("part", self._node(sender), text_or_hex(message))
        kinds = dict.fromkeys(kind for kind, _ in parts)
        return Named(", ".join(kinds), self._node(sender), "; ".join(text for _, text in parts))

    def _node(self, sender: str) -> str:
        """Return the device that hears the sender, or the sender if only the outside hears it."""
        return next((device for device in self._devices if device != sender), sender)


def namer(bus: Bus[Any], members: Sequence[Member]) -> Namer:
    """Return the namer of a serial line with these devices."""
    readers = (
        reader
        for member in members
        if isinstance(settings := member.entry.settings, HasLines)
        for link in member.links
        if (reader := settings.line_reader(link, member.entry.name)) is not None
    )
    return SerialNames([member.entry.name for member in members], next(readers, None) or TextLine())
