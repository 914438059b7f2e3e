"""A CAN network as a DBC file, by the library cantools (the extra `dbc`).

DBC files are in the code page 1252 of Windows, and their names have 32 characters; cantools shortens longer ones and
keeps the whole name in the attributes that tools read for this.
"""

from collections import OrderedDict
from typing import Final

from cantools.database import Database
from cantools.database.can import Message, Node, Signal
from cantools.database.conversion import BaseConversion
from cantools.database.namedsignalvalue import NamedSignalValue

from fieldrig_devices.export import network

ENCODING: Final = "cp1252"


def text_of(described: network.Network) -> bytes:
    """Return the content of the file."""
    messages = [_message(message) for message in described.messages.values()]
    nodes = [Node(name, comment=_plain(about)) for name, about in described.nodes.items()]
    return Database(messages, nodes, version="").as_dbc_string().encode(ENCODING, "replace")


def _message(message: network.Message) -> Message:
    selector = next((signal.name for signal in message.signals if signal.is_selector), None)
    return Message(
        message.identifier,
        message.name,
        message.length,
        [_signal(signal, message, selector) for signal in message.signals],
        comment=_plain(message.about),
        senders=[message.sender] if message.sender else [],
        cycle_time=message.period_ms,
        is_extended_frame=message.is_extended,
    )


def _signal(signal: network.Signal, message: network.Message, selector: str | None) -> Signal:
    choices: OrderedDict[int, str | NamedSignalValue] = OrderedDict(
        (number, _plain(name) or "") for number, name in signal.choices.items()
    )
    is_chosen = signal.selected_by is not None
    return Signal(
        signal.name,
        signal.start,
        signal.length,
        is_signed=signal.is_signed,
        conversion=BaseConversion.factory(signal.scale, signal.offset, choices or None, signal.is_float),
        minimum=signal.low,
        maximum=signal.high,
        unit=_plain(signal.unit),
        comment=_plain(signal.about),
        receivers=list(message.receivers),
        is_multiplexer=signal.is_selector,
        multiplexer_ids=[signal.selected_by] if signal.selected_by is not None else None,
        multiplexer_signal=selector if is_chosen else None,
    )


def _plain(text: str) -> str | None:
    """Return a text without what ends a text in such a file; None if it is empty."""
    return " ".join(text.replace('"', "'").replace("\\", "/").split()) or None
