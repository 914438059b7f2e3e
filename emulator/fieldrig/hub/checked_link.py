"""The rule for every end of a bus: a message that the medium cannot carry raises where it is sent.

All ends that the kernel makes follow it: under virtual time (`node`), in the hub's process (`hub`), in another process
(`attach`), and around the end of a direct bus (`CheckedLink`).  `Bus.check` and `Bus.check_interest` decide.  Such a
message is a fault of our own code, so the TypeError or ValueError is not caught.
"""

from collections.abc import Callable, Sequence
from typing import Any

from fieldrig.bus import Bus
from fieldrig.link import PoweredLink, SharedWords, patience_of, words_behind
from fieldrig.outside.untrusted import shown


def unsendable(cause: Exception, member: str, bus: str, message: Any) -> Exception:
    """Return the exception to raise from `cause`, which `Bus.check` raised."""
    return _of_kind(cause)(f"{member} cannot send {shown(message)} on {bus}: {cause}")


def uninteresting(cause: Exception, member: str, bus: str, interest: Any) -> Exception:
    """Return the exception to raise from `cause`, which `Bus.check_interest` raised."""
    return _of_kind(cause)(f"{member} cannot listen to {shown(interest)} on {bus}: {cause}")


class CheckedLink:
    """A device's end of a direct bus that checks messages and interests."""

    def __init__(self, link: Any, bus: Bus[Any], member: str) -> None:
        self._link, self._bus, self._member = link, bus, member
        self._check, self._send = bus.check, link.send

    def send(self, message: Any) -> None:
        try:
            self._check(message)
        except (TypeError, ValueError) as cause:
            raise unsendable(cause, self._member, self._bus.name, message) from cause
        self._send(message)

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        try:
            self._bus.check_interest(interest)
        except (TypeError, ValueError) as cause:
            raise uninteresting(cause, self._member, self._bus.name, interest) from cause
        self._link.on_receive(handler, interest)

    def switch(self, is_on: bool) -> None:
        """Tell the bus's own end whether its device has power, if it wants to know (`PoweredLink`)."""
        if isinstance(self._link, PoweredLink):
            self._link.switch(is_on)

    @property
    def patience_ns(self) -> int:
        """The patience of the bus's own end (`PatientLink`)."""
        return patience_of(self._link)

    @property
    def words(self) -> SharedWords | None:
        """The memory behind the bus's own end (`MemoryLink`)."""
        return words_behind(self._link)


def _of_kind(cause: Exception) -> type[Exception]:
    return TypeError if isinstance(cause, TypeError) else ValueError
