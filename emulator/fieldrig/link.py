"""A device's end of one bus."""

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

M = TypeVar("M")
T = TypeVar("T")


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


def shared(link: Link[Any], kind: type[T]) -> T:
    """The one object of this kind that all devices of this process have which are at the same bus.

    It is for what is cheaper done for many at once.  What they send must not depend on who shares their process.
    """
    common: dict[type, Any] = getattr(link, "common", {})
    if kind not in common:
        common[kind] = kind()
    found: T = common[kind]
    return found
