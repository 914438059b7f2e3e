"""Messages of a DualPort memory by name, and the map of the memory for tools that read it as registers."""

from collections.abc import Sequence
from typing import Any, Protocol, runtime_checkable

from fieldrig.bus import Bus
from fieldrig.traces.names import Member, Named, Namer
from fieldrig.traces.parts import Part, Parts
from fieldrig_bus.dualport.message import Words, show
from fieldrig_devices.pam.language.ports import PortPlan
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.simatic.words import SimaticWords
from fieldrig_devices.pam.ports.vme.crcs import with_crcs
from fieldrig_devices.pam.ports.vme.words import VmeWords
from fieldrig_devices.pam.ports.words import Piece, PlainWords, WordMap, in_text, pieces


@runtime_checkable
class HasDualPort(Protocol):
    """The settings of a device whose application declares a DualPort."""

    def dual_port(self) -> WordMap | None:
        """Return the map of its memory; None if there is no DualPort, or if the application has mistakes."""


def map_of(plans: Sequence[PortPlan], options: PortOptions) -> WordMap | None:
    """Return the map of the DualPort among the ports of an application."""
    for plan in plans:
        if plan.kind == "DUAL_PORT":
            return SimaticWords(plan)
        if plan.kind == "VME DUALPORT":
            return VmeWords(with_crcs(plan.variables, options), options.first_item)
    return None


class DualPortNames:
    """Names the messages of one memory."""

    def __init__(self, devices: Sequence[str], words: WordMap) -> None:
        """`devices` are those at the memory, by their names in the rig."""
        self._devices, self._words = devices, words

    def __call__(self, message: Any, sender: str = "") -> Named:
        if not isinstance(message, Words):
            return Named("fault", sender, show(message))
        found = pieces(self._words, message.first, message.values)
        kinds = ", ".join(dict.fromkeys(piece.kind for piece in found))
        node = next((device for device in self._devices if device != sender), sender)
        return Named(kinds, node, in_text(found))

    def parts(self, message: Any, request: bytes = b"") -> Parts | None:
        """Return what the words of a message are, one by one."""
        if not isinstance(message, Words):
            return None
        return Parts("", "words", _parts(pieces(self._words, message.first, message.values)))


def _parts(found: Sequence[Piece]) -> list[Part]:
    return [Part(piece.name, "", piece.value, piece.value) for piece in found]


def namer(bus: Bus[Any], members: Sequence[Member]) -> Namer:
    """Return the namer of a DualPort memory with these devices."""
    maps = (
        words
        for member in members
        if isinstance(settings := member.entry.settings, HasDualPort)
        if (words := settings.dual_port()) is not None
    )
    return DualPortNames([member.entry.name for member in members], next(maps, None) or PlainWords())
