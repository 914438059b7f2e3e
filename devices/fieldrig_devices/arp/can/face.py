"""The card as a CANopen node (CiA 301): what a foreign master reads and commands, and what cards tell each other.

Source: digest chapters 7 to 10, 17 and 20; the manual describes no objects, so `arp-card.eds` is ours, and
docs/arp-can.md tells it.  The node's reset is not the card's: it starts communication anew, the program goes on.
"""

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.arp.can.exchange import ExchangeSettings
from fieldrig_devices.arp.outside import Outside


class CanFace:
    """Node-ID is @Par[5] in RAM when it starts.  `store` is a section of its own: what 1010h keeps."""

    def __init__(
        self,
        clock: Clock,
        name: str,
        can: Link[CanFrame],
        card: Outside,
        store: Store,
        exchange: ExchangeSettings | None = None,
    ) -> None:
        self._clock, self._name, self._can, self._card, self._store = clock, name, can, card, store
        self._exchange = exchange or ExchangeSettings()

    def start(self) -> None:
        """Power-on, once the card's parameters are loaded: boot-up message, then operational."""

    def refresh(self) -> None:
        """Each pass of the scheduler: what PDOs carry follows the card; errors are told by EMCY."""
