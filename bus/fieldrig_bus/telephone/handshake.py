"""How two modems at a line agree on a carrier: each says what it can do, trains, and sends its carrier.

The answering modem speaks first, and again until it is heard.
Source: the order of ITU-T V.25 and V.8, without their signals.
"""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import Alarm, Clock, S
from fieldrig.link import Link
from fieldrig_bus.telephone.message import Carrier, Offer, TelephoneMessage, agreed
from fieldrig_bus.telephone.modulation import Agreed

REPEAT_NS: Final = 1 * S


class Handshake:
    """`on_connected` is called with what was agreed and the carrier of the other end; `on_failed` if they cannot."""

    def __init__(
        self,
        clock: Clock,
        link: Link[TelephoneMessage],
        offer: Offer,
        training_ns: int,
        on_connected: Callable[[Agreed, Carrier], None],
        on_failed: Callable[[], None],
    ) -> None:
        self._clock, self._link, self._offer, self._training_ns = clock, link, offer, training_ns
        self._on_connected, self._on_failed = on_connected, on_failed
        self._has_offered = False
        self.has_heard = False
        """The other modem has spoken."""
        self._agreed: Agreed | None = None
        self._ours: Carrier | None = None
        self._theirs: Carrier | None = None
        self._timer = Alarm(self._clock)

    def answer(self) -> None:
        """Speak first, as the modem that answers."""
        self._timer.after(REPEAT_NS, self.answer)  # first, as the other offer may arrive while ours is sent
        self._offer_again()

    def stop(self) -> None:
        self._timer.stop()

    def hear(self, message: Offer | Carrier) -> None:
        if isinstance(message, Carrier):
            self._theirs = message if message.bps else None
            self._connect()
        elif self._agreed is None:
            self._on_offer(message)

    def _offer_again(self) -> None:
        self._has_offered = True
        self._link.send(self._offer)

    def _on_offer(self, theirs: Offer) -> None:
        self.stop()
        self.has_heard = True
        self._agreed = agreed(self._offer, theirs)
        if self._agreed is not None:
            self._timer.after(self._training_ns, self._on_trained)
        if not self._has_offered:
            self._offer_again()
        if self._agreed is None:
            self._on_failed()

    def _on_trained(self) -> None:
        assert self._agreed is not None
        ours = Carrier(self._agreed.bps, self._agreed.is_corrected)
        self._link.send(ours)
        self._ours = ours  # not before, so that a carrier that arrives meanwhile connects once
        self._connect()

    def _connect(self) -> None:
        if self._agreed is not None and self._ours is not None and self._theirs is not None:
            self._on_connected(self._agreed, self._theirs)
