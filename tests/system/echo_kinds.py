"""A master that only keeps the cycle, and drives that only answer: for the ring itself, between processes."""

from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point, Value
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.ring.sercos.message import Answers, Cycle, Mdt, Mst, RingMessage

CYCLE_NS = 10 * MS


class Metronome(Device):
    """The ring's master."""

    def __init__(self, clock: Clock, ring: Link[RingMessage]) -> None:
        self._clock, self._ring = clock, ring
        self._number = 0
        self._last = Answers(0, (), False)
        ring.on_receive(self._on_message, ["master"])

    def start(self) -> None:
        self._number += 1
        self._ring.send(Mst(self._number, b"\xff\x04"))
        self._clock.call_at(self._clock.now_ns() + CYCLE_NS, self.start)

    def points(self) -> dict[str, Point]:
        return {
            "number": Point(lambda: self._number),
            "closed": Point(lambda: self._last.ring_closed),
            "heard": Point(lambda: " ".join(str(at[0]) for at in self._last.ats)),
        }

    def _on_message(self, message: RingMessage) -> None:
        assert isinstance(message, Answers)
        self._last = message
        self._ring.send(Mdt(b"\xff" + self._number.to_bytes(4, "little")))


class EchoSettings(Settings):
    address: int


class Echo(Device):
    """Returns each number that it receives, and checks that the numbers are consecutive."""

    def __init__(self, settings: EchoSettings, ring: Link[RingMessage]) -> None:
        self._address, self._ring = settings.address, ring
        self._told = self._heard = self._gaps = 0
        self._is_wrong = False
        ring.on_receive(self._on_message, [["drive", settings.address]])

    def points(self) -> dict[str, Point]:
        return {
            "heard": Point(lambda: self._heard),
            "told": Point(lambda: self._told),
            "gaps": Point(lambda: self._gaps),
            "wrong": Point(lambda: self._is_wrong, self._go_wrong),
        }

    def _go_wrong(self, value: Value) -> None:
        self._is_wrong = bool(value)

    def _on_message(self, message: RingMessage) -> None:
        assert isinstance(message, Cycle)
        if self._is_wrong:
            raise RuntimeError("lost the count")
        self._heard += 1
        if message.mdt:
            told = int.from_bytes(message.mdt[1:], "little")
            self._gaps += self._told not in (0, told - 1)
            self._told = told
        self._ring.send(bytes((self._address,)) + message.mdt[1:])
