"""A telephone network in virtual time with two or more members, whose hands the test is."""

from typing import Any

from fieldrig.clock import MS
from fieldrig_bus.telephone.bus import TelephoneSettings, TelephoneVirtual
from fieldrig_bus.telephone.message import Carrier, Dial, Hook, Offer, TelephoneMessage
from fieldrig_bus.telephone.modulation import everything

A, B, C = "a", "b", "c"
NUMBERS = {A: "100", B: "200", C: "301"}


class Exchange:
    """The model of a network, and what each member has heard with its instant in milliseconds."""

    def __init__(self, **settings: Any) -> None:
        bus = TelephoneVirtual("net", TelephoneSettings.model_validate({"numbers": NUMBERS, **settings}))
        self.model = bus.model()
        self.model.begin(0, __import__("random").Random(1))
        self.now_ns = 0
        self.heard: dict[str, list[tuple[float, TelephoneMessage]]] = {}
        for member in NUMBERS:
            self.model.join(member)
            self.model.listen(0, member, None)
            self.heard[member] = []

    def run_to(self, until_ms: float) -> "Exchange":
        until_ns = round(until_ms * MS)
        while (next_ns := self.model.next_ns()) is not None and next_ns <= until_ns:
            for delivery in self.model.collect(next_ns):
                for receiver in delivery.receivers:
                    self.heard[receiver].append((delivery.time_ns / MS, delivery.message))
        self.now_ns = until_ns
        return self

    def say(self, member: str, *messages: TelephoneMessage) -> "Exchange":
        for message in messages:
            self.model.submit(self.now_ns, member, message)
        return self.run_to(self.now_ns / MS)

    def take(self, member: str) -> list[TelephoneMessage]:
        heard, self.heard[member] = self.heard[member], []
        return [message for _, message in heard]

    def data(self, member: str) -> bytes:
        return b"".join(message for message in self.take(member) if isinstance(message, bytes))

    def connected(self, bps: int = 9600, is_corrected: bool = False) -> "Exchange":
        """A call from `a` to `b` at which both send their carriers, 100 ms later."""
        self.say(A, Hook(True), Dial("200")).say(B, Hook(True), Offer(everything()))
        self.run_to(50).say(A, Offer(everything()))
        self.say(A, Carrier(bps, is_corrected)).say(B, Carrier(bps, is_corrected)).run_to(100)
        for member in (A, B):
            self.take(member)
        return self
