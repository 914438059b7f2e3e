"""A device's end of one bus."""

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

M = TypeVar("M")


class Link(Protocol[M]):
    """A device's end of one bus.

    It sends messages, and calls a handler for those that arrive; the bus finds the receivers.
    """

    def send(self, message: M) -> None:
        """Hand a message to the bus.  It never blocks, and never raises for a state of the bus."""

    def on_receive(self, handler: Callable[[M], None], interest: Sequence[object] | None = None) -> None:
        """Call `handler` with every message that arrives and matches `interest`.

        `interest` is JSON data in the terms of the bus: acceptance filters `(identifier, mask)` on CAN, unit ids on
        Modbus, names on wires.  None matches everything.  Other messages cost this device nothing, as they are not even
        carried to its process.  A second call replaces handler and interest of the first.
        """


class UnconnectedLink:
    """An end of a bus that leads nowhere: it drops what is sent, and nothing arrives."""

    def send(self, message: Any) -> None:
        """Drop the message."""

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        """Do nothing, as no message ever arrives."""
