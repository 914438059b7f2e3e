"""A device's end of one bus."""

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar, runtime_checkable

M = TypeVar("M")


class Link(Protocol[M]):
    """A device's end of one bus.

    It sends messages, and calls a handler for those that arrive; the bus finds the receivers.
    """

    def send(self, message: M) -> None:
        """Hand a message to the bus.  It never blocks, and never raises for a state of the bus.

        In real time, what has arrived meanwhile may be handled before it returns: whatever a handler reads or changes
        is set before.
        """

    def on_receive(self, handler: Callable[[M], None], interest: Sequence[object] | None = None) -> None:
        """Call `handler` with every message that arrives and matches `interest`.

        `interest` is JSON data in the terms of the bus: acceptance filters `(identifier, mask)` on CAN, unit ids on
        Modbus, names on wires.  None matches everything.  Other messages cost this device nothing, as they are not even
        carried to its process.  A second call replaces handler and interest of the first.
        """


@runtime_checkable
class PatientLink(Protocol):
    """A link that tolerates late answers on a busy host, as a ring in real time may."""

    @property
    def patience_ns(self) -> int:
        """How long late answers are tolerated, in nanoseconds; 0: not at all."""


def patience_of(link: object) -> int:
    """How long this link tolerates late answers, in nanoseconds; 0 for a link without patience."""
    return link.patience_ns if isinstance(link, PatientLink) else 0


@runtime_checkable
class PoweredLink(Protocol):
    """A link that can tell its bus that its device has no power."""

    def switch(self, is_on: bool) -> None: ...


class SharedWords(Protocol):
    """Words of a memory that other processes share; each is read and written as a whole."""

    def __getitem__(self, index: int, /) -> int: ...

    def __setitem__(self, index: int, value: int, /) -> None: ...


@runtime_checkable
class MemoryLink(Protocol):
    """A link to a memory, which reports nothing by itself: a device reads its words as often as it wants."""

    @property
    def words(self) -> SharedWords | None:
        """The words; None for a link that leads to no memory."""


def words_behind(link: object) -> SharedWords | None:
    """Return the memory that this link leads to; None for a link without one."""
    return link.words if isinstance(link, MemoryLink) else None


class UnconnectedLink:
    """An end of a bus that leads nowhere: it drops what is sent, and nothing arrives."""

    def send(self, message: Any) -> None:
        """Drop the message."""

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        """Do nothing, as no message ever arrives."""
