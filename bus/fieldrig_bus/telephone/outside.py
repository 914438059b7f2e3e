"""The modem of an outside program at a line of the exchange: no commands, every rate, data as they are.

It calls a number at once, or answers the calls to its own number.
"""

from collections.abc import Callable

from fieldrig.clock import MS, Alarm, Clock, S
from fieldrig.link import Link
from fieldrig_bus.sending_ahead import AHEAD_NS
from fieldrig_bus.telephone.handshake import Handshake
from fieldrig_bus.telephone.message import Carrier, Dial, Heard, Hook, Offer, Ready, TelephoneMessage, Tone
from fieldrig_bus.telephone.modulation import OPTIONAL, Agreed, everything
from fieldrig_bus.telephone.pump import Pump

TRAINING_NS = 100 * MS
PATIENCE_NS = 60 * S
"""How long a call may take to connect; after that, the program is not on the line any more."""


class OutsideModem:
    """`on_data` gets what the other end sends; `on_over` is called when a call has ended."""

    def __init__(
        self,
        link: Link[TelephoneMessage],
        clock: Clock,
        on_data: Callable[[bytes], None],
        on_over: Callable[[], None],
    ) -> None:
        self._link, self._clock, self._on_data, self._on_over = link, clock, on_data, on_over
        self.pump = Pump(link, clock)
        self._number = ""
        self._handshake: Handshake | None = None
        self._is_off = False
        self._limit = Alarm(self._clock)

    def call(self, number: str) -> None:
        self._number = number
        self._seize()

    def answer(self) -> None:
        self._seize()
        assert self._handshake is not None
        self._handshake.answer()

    def set_ready(self, is_ready: bool) -> None:
        """Tell the other end whether the program reads what it sends."""
        if self._is_off:
            self._link.send(Ready(is_ready))

    def finish(self) -> None:
        """Hang up when everything that waits has been sent."""
        if self.pump.is_running and self.pump.waiting:
            self.pump.on_empty = self.finish
        else:
            self._clock.call_at(self._clock.now_ns() + 2 * AHEAD_NS, self.hang_up)

    def hang_up(self) -> None:
        if self._is_off:
            self._is_off = False
            self._link.send(Hook(False))
            self._limit.stop()
            self.pump.start(Carrier(0))
            if self._handshake is not None:
                self._handshake.stop()
                self._handshake = None
            self._on_over()

    def from_network(self, message: TelephoneMessage) -> None:
        if not self._is_off:
            return
        match message:
            case bytes():
                self._on_data(message)
            case Heard(tone=Tone.DIAL) if self._number:
                self._link.send(Dial(self._number))
                self._number = ""
            case Heard(tone=Tone.BUSY | Tone.UNOBTAINABLE):
                self.hang_up()
            case Offer() | Carrier() if self._handshake is not None:
                self._handshake.hear(message)
            case Ready(is_ready=is_ready):
                self.pump.hold(not is_ready)

    def _seize(self) -> None:
        self._is_off = True
        self._handshake = Handshake(
            self._clock, self._link, Offer(everything(), OPTIONAL), TRAINING_NS, self._on_connected, self.hang_up
        )
        self._limit.after(PATIENCE_NS, self.hang_up)
        self._link.send(Hook(True))

    def _on_connected(self, agreed: Agreed, theirs: Carrier) -> None:
        self._limit.stop()
        self.pump.start(Carrier(agreed.bps, agreed.is_corrected, theirs.is_paced))
