"""A device's end of one bus."""

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

M = TypeVar("M")


class Link(Protocol[M]):
    """Send messages to a bus and be told of those that arrive; who is at the other end is the bus's affair."""

    def send(self, message: M) -> None:
        """Hand a message to the bus.  It never blocks and never raises for the sake of the bus."""

    def on_receive(self, handler: Callable[[M], None], interest: Sequence[object] | None = None) -> None:
        """Call `handler` with every message that arrives and is of interest.

        `interest` is JSON data in the words of the bus: acceptance filters `(identifier, mask)` on CAN, unit
        ids on Modbus, names on wires.  None is everything.  What is of no interest costs this device nothing:
        it is not even carried to its process.  A second call replaces handler and interest of the first.
        """


class UnconnectedLink:
    """An end of a bus that leads nowhere: nothing that is sent goes out, and nothing arrives."""

    def send(self, message: Any) -> None:
        """Drop the message."""

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        """Do nothing, as no message ever arrives."""
