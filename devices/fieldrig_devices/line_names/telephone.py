"""The messages of a telephone network by name: who calls whom, what is heard, and what modems tell each other.

A call is followed from its first digit, so that its data have a direction: the node is the other end of the call.
"""

from collections.abc import Sequence
from typing import Any, Final

from fieldrig.bus import Bus
from fieldrig.traces.names import Member, Named, Namer
from fieldrig_bus.telephone.bus import TelephoneSettings
from fieldrig_bus.telephone.codec import show
from fieldrig_bus.telephone.message import Carrier, Dial, Heard, Hook, Offer, Ready, Ring
from fieldrig_bus.telephone.numbering import Numbering
from fieldrig_devices.line_names.text_line import TextLine

MOST_DIGITS: Final = 64
MOST_CALLERS: Final = 64
"""Callers that are remembered; programs outside come with a name of their own for each call."""


class TelephoneNames:
    """Names the messages of one network."""

    def __init__(self, settings: TelephoneSettings) -> None:
        self._numbering = Numbering(settings.numbers, settings.outside_prefix)
        self._members = {number: member for member, number in settings.numbers.items()}
        self._dialled: dict[str, str] = {}
        self._others: dict[str, str] = {}
        """The other end of the call of each subscriber."""
        self._texts: dict[str, TextLine] = {}
        """The reader of what passes in the call, by the caller."""

    def __call__(self, message: Any, sender: str = "") -> Named:
        match message:
            case Hook(is_off=is_off):
                return self._hook(sender, is_off)
            case Dial(digits=digits):
                return self._dial(sender, digits)
            case Ring(is_on=is_on, caller=caller):
                return self._ring(is_on, caller)
            case Heard():
                return Named("tone", "", message.tone.name.lower())
            case Offer():
                return Named("handshake", self._others.get(sender, ""), show(message))
            case Carrier(bps=bps):
                return Named("connect" if bps else "carrier lost", self._others.get(sender, ""), show(message))
            case Ready():
                return Named("flow control", self._others.get(sender, ""), show(message))
            case bytes():
                return self._data(sender, message)
        return Named("fault", sender, show(message))

    def _hook(self, sender: str, is_off: bool) -> Named:
        other = self._others.get(sender, "")
        self._dialled.pop(sender, None)
        if is_off:
            return Named("answer" if other else "seize", other, "off hook")
        self._others.pop(sender, None)
        self._texts.pop(sender, None)
        return Named("hang up", other, "on hook")

    def _dial(self, sender: str, digits: str) -> Named:
        dialled = (self._dialled.get(sender, "") + digits)[-MOST_DIGITS:]
        called = self._numbering.meaning(dialled)
        _keep(self._dialled, sender, dialled)
        if not isinstance(called, str):
            return Named("dial", "", digits)
        _keep(self._others, sender, called)
        _keep(self._others, called, sender)
        text = TextLine()
        _keep(self._texts, sender, text)
        _keep(self._texts, called, text)
        return Named("call", called, f"{digits}: {sender or 'outside'} calls {called}")

    def _ring(self, is_on: bool, caller: str) -> Named:
        name = self._members.get(caller, "")
        of = f", called by {name or 'outside'}{f' ({caller})' if caller else ''}"
        return Named("ring" if is_on else "ring off", self._others.get(name, ""), f"{'on' if is_on else 'off'}{of}")

    def _data(self, sender: str, data: bytes) -> Named:
        other = self._others.get(sender, "")
        if sender not in self._texts:  # the trace begins within the call
            _keep(self._texts, sender, TextLine())
        parts = self._texts[sender](sender, data)
        kinds = ", ".join(dict.fromkeys(f"data: {kind}" for kind, _ in parts))
        to = f" to {other}" if other else ""
        return Named(kinds, other, f"{sender or 'outside'}{to}: {'; '.join(text for _, text in parts)}")


def _keep(table: dict[str, Any], key: str, value: Any) -> None:
    table.pop(key, None)
    table[key] = value
    if len(table) > MOST_CALLERS:
        del table[next(iter(table))]


def namer(bus: Bus[Any], members: Sequence[Member]) -> Namer:
    """Return the namer of a telephone network."""
    settings = bus.settings
    return TelephoneNames(settings if isinstance(settings, TelephoneSettings) else TelephoneSettings())
