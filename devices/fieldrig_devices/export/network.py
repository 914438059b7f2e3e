"""A CAN network as tools for CAN describe it: nodes, and messages with their signals.

Bits are counted as on the bus: bit 0 is the lowest one of the first byte, and numbers have their lowest byte first, as
CANopen has them (CiA 301, 7.1.3).
"""

import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, count
from typing import Final

NO_CHOICES: Final[Mapping[int, str]] = {}
MOST_BITS: Final = 64
"""The most bits of data in a CAN frame."""


@dataclass(frozen=True, slots=True)
class Signal:
    """Some bits of a message as a value, which is `raw * scale + offset` in `unit`."""

    name: str
    start: int
    length: int
    is_signed: bool = False
    is_float: bool = False
    scale: float = 1.0
    offset: float = 0.0
    unit: str = ""
    choices: Mapping[int, str] = field(default_factory=dict)
    """Names of numbers."""
    low: float | None = None
    high: float | None = None
    about: str = ""
    selected_by: int | None = None
    """The number of the message's selector with which these bits are this signal, or None if they always are."""
    is_selector: bool = False


@dataclass(frozen=True, slots=True)
class Message:
    identifier: int
    name: str
    length: int
    """Bytes of data."""
    signals: Sequence[Signal] = ()
    sender: str = ""
    receivers: Sequence[str] = ()
    about: str = ""
    is_extended: bool = False
    period_ms: int | None = None

    @property
    def key(self) -> tuple[int, bool]:
        """A frame with this identifier, and 29 bits or not, is this message."""
        return self.identifier, self.is_extended


@dataclass(slots=True)
class Network:
    """One bus: what each node is, by name, and the messages by their keys."""

    name: str
    nodes: dict[str, str] = field(default_factory=dict)
    messages: dict[tuple[int, bool], Message] = field(default_factory=dict)

    def add(self, messages: Iterable[Message]) -> None:
        """Add messages.  Of two with one identifier the first one stays; the second one's receivers hear it as well."""
        for message in messages:
            first = self.messages.setdefault(message.key, message)
            heard = dict.fromkeys((*first.receivers, *message.receivers))
            self.messages[message.key] = replace(first, receivers=tuple(heard))


def identifier_of(text: str) -> str:
    """Return a text as a name in the language C, which files of other tools ask for."""
    word = re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_") or "value"
    return f"_{word}" if word[0].isdigit() else word


def with_unique_names(signals: Iterable[Signal]) -> Iterator[Signal]:
    """Yield signals with names of C; a name that is taken gets a number."""
    taken: set[str] = set()
    for signal in signals:
        name = free_name(signal.name, taken)
        taken.add(name.lower())
        yield replace(signal, name=name)


def free_name(text: str, taken: Container[str]) -> str:
    """Return a name of C that is not taken, whatever its capitals; `taken` has small letters."""
    name = identifier_of(text)
    numbered = (f"{name}_{number}" for number in count(2))
    return next(each for each in chain((name,), numbered) if each.lower() not in taken)
