"""One link to a CAN bus for several services, or several nodes, of one device.

Each has an end of its own, a `Link` like any other.  The interest in the bus is that of all ends together, and a frame
finds its receivers by one look into a dictionary: the ends that want an identifier are determined when it arrives for
the first time, so filters with masks cost no more than exact ones.  Ends may be shared again.

A controller does not receive its own frames, so ends normally don't receive frames of the other ends of their device.
Where a master and slaves are in one device that would be wrong: an NMT command or a SYNC of the master is meant for the
device's own slaves as well.  An end that `hears_others` gets such frames when they have been on the wire, as the slaves
of other devices do (with the word "own" in `acceptance`, the bus returns the device's own frames).  So it receives
nothing from a controller in bus-off, and no handler is called from within `send`.

The order of sending distinguishes a frame that comes back from an equal frame of another device.  If two devices send
equal frames at the same time, the two may be confused; each end still receives the right number of them.
"""

from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Final

from fieldrig.link import Link
from fieldrig_bus.can.acceptance import ERRORS, EVERYTHING, OWN, STATE, Filters, filters_of, passes, received, wants
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BusState, CanError, CanState

_MOST_CACHED: Final = 4096  # identifiers
_MOST_UNDER_WAY: Final = 10_000  # frames; the bus queues no more than that for one member

_Handler = Callable[[Any], None]


class Share:
    """One end of a shared link."""

    def __init__(self, shared: "SharedLink", hears_others: bool) -> None:
        self._shared = shared
        self.hears_others = hears_others
        self.handler: _Handler | None = None
        self.interest: Sequence[Any] | None = ()
        self.filters: Filters | None = ()

    def send(self, message: CanFrame) -> None:
        self._shared.send(self, message)

    def on_receive(self, handler: _Handler, interest: Sequence[object] | None = None) -> None:
        self.filters = filters_of(interest)
        self.handler, self.interest = handler, None if interest is None else list(interest)
        self._shared.connect()

    def wants(self, word: str) -> bool:
        return wants(self.interest, word)


class SharedLink:
    """A link of one device that several ends share."""

    def __init__(self, can: Link[CanFrame]) -> None:
        self._can = can
        self._shares: list[Share] = []
        self._interest: list[Any] | None = []
        self._routes: dict[int, tuple[_Handler, ...]] = {}
        """Handlers for a frame of another device, by its identifier as `received` returns it."""
        self._listens_to_itself = False
        self._under_way: deque[tuple[Share, CanFrame]] = deque(maxlen=_MOST_UNDER_WAY)
        """Frames that were sent and have not come back yet, if an end waits for them."""
        self._own: set[int] = set()
        """Identifiers of all frames that have ever been under way."""

    def share(self, *, hears_others: bool = False) -> Link[CanFrame]:
        """A further end.  With `hears_others` it also gets frames of the other ends that are of interest."""
        share = Share(self, hears_others)
        self._shares.append(share)
        return share

    def send(self, sender: Share, message: CanFrame) -> None:
        if self._listens_to_itself and type(message) is CanFrame:
            self._under_way.append((sender, message))
            self._own.add(message.identifier)
        self._can.send(message)

    def connect(self) -> None:
        """Update the interest in the bus after that of an end has changed."""
        self._routes.clear()
        self._listens_to_itself = any(
            share.wants(OWN) or (share.hears_others and share.filters != ()) for share in self._shares
        )
        if not self._listens_to_itself:
            self._under_way.clear()
        interest = self._merged()
        if interest != self._interest:
            self._interest = interest
            self._can.on_receive(self._on_message, interest)

    def _merged(self) -> list[Any] | None:
        words = [word for word in (ERRORS, STATE) if any(share.wants(word) for share in self._shares)]
        if self._listens_to_itself:
            words = [OWN, STATE, *(word for word in words if word != STATE)]
        filters = [share.filters for share in self._shares]
        if None in filters:
            return [list(EVERYTHING), *words] if words else None
        pairs = dict.fromkeys(pair for several in filters if several is not None for pair in several)
        return [*map(list, pairs), *words]

    def _on_message(self, message: Any) -> None:
        if type(message) is not CanFrame:
            self._on_notice(message)
            return
        if self._under_way and message.identifier in self._own:
            sender = self._sender_of(message)
            if sender is not None:
                self._on_own(sender, message)
                return
        identifier = received(message)
        handlers = self._routes.get(identifier)
        if handlers is None:
            handlers = self._find(identifier)
        for handle in handlers:
            handle(message)

    def _find(self, identifier: int) -> tuple[_Handler, ...]:
        if len(self._routes) >= _MOST_CACHED:
            self._routes.clear()
        handlers = tuple(
            share.handler for share in self._shares if share.handler is not None and passes(identifier, share.filters)
        )
        self._routes[identifier] = handlers
        return handlers

    def _sender_of(self, frame: CanFrame) -> Share | None:
        """The end whose frame has come back; None if it is another device's.  Frames sent before it were lost."""
        under_way = self._under_way
        for index, (sender, sent) in enumerate(under_way):
            if sent == frame:
                for _ in range(index + 1):
                    under_way.popleft()
                return sender
        return None

    def _on_own(self, sender: Share, frame: CanFrame) -> None:
        identifier = received(frame)
        for share in tuple(self._shares):
            is_wanted = (
                share.wants(OWN) if share is sender else share.hears_others and passes(identifier, share.filters)
            )
            if is_wanted and share.handler is not None:
                share.handler(frame)

    def _on_notice(self, notice: Any) -> None:
        if isinstance(notice, BusState) and notice.state is CanState.BUS_OFF:
            self._under_way.clear()  # the controller has given up all waiting frames
        word = {BusState: STATE, CanError: ERRORS}.get(type(notice))
        for share in tuple(self._shares):
            if word is not None and share.wants(word) and share.handler is not None:
                share.handler(notice)
