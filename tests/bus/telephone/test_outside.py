"""The modem of a program outside, with the exchange in the hands of the test."""

import pytest

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.telephone.message import Carrier, Dial, Heard, Hook, Offer, Ready, TelephoneMessage, Tone
from fieldrig_bus.telephone.modulation import everything
from fieldrig_bus.telephone.outside import OutsideModem


class Bench:
    def __init__(self) -> None:
        self.clock, self.link = VirtualClock(), RecordedLink[TelephoneMessage]()
        self.data, self.over = b"", 0
        self.modem = OutsideModem(self.link, self.clock, self._on_data, self._on_over)

    def _on_data(self, data: bytes) -> None:
        self.data += data

    def _on_over(self) -> None:
        self.over += 1

    def hear(self, *messages: TelephoneMessage) -> "Bench":
        for message in messages:
            self.modem.from_network(message)
        return self

    def wait(self, seconds: float) -> "Bench":
        self.clock.advance_to(self.clock.now_ns() + round(seconds * S))
        return self

    def connected(self) -> "Bench":
        self.modem.call("200")
        self.hear(Heard(Tone.DIAL), Heard(Tone.RINGING), Heard(Tone.SILENCE), Offer(everything(300, 9600), 1))
        self.wait(0.1).hear(Carrier(9600, True))
        self.link.take()
        return self


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_it_dials_at_the_first_dial_tone_only(bench: Bench) -> None:
    bench.modem.call("200")
    assert bench.hear(Heard(Tone.DIAL), Heard(Tone.DIAL)).link.take() == [Hook(True), Dial("200")]


def test_it_answers_an_offer_with_its_own_and_then_with_the_carrier(bench: Bench) -> None:
    bench.modem.call("200")
    bench.link.take()
    bench.hear(Offer(everything(300, 9600), 1)).wait(0.1)
    assert bench.link.take() == [Offer(everything(), 1), Carrier(9600, True)]
    bench.modem.pump.send(b"early")
    assert bench.link.take() == []
    assert bench.hear(Carrier(9600, True)).link.take() == [b"early"]


@pytest.mark.parametrize("tone", [Tone.BUSY, Tone.UNOBTAINABLE])
def test_a_call_that_cannot_be_is_over(bench: Bench, tone: Tone) -> None:
    bench.modem.call("200")
    bench.hear(Heard(Tone.DIAL), Heard(tone))
    assert (bench.link.take()[-1], bench.over) == (Hook(False), 1)


def test_a_call_that_nobody_answers_is_over_after_a_minute(bench: Bench) -> None:
    bench.modem.call("200")
    bench.hear(Heard(Tone.DIAL), Heard(Tone.RINGING)).wait(59.9)
    assert bench.over == 0
    assert bench.wait(0.2).over == 1
    assert bench.link.take()[-1] == Hook(False)


def test_a_call_that_is_connected_has_no_limit(bench: Bench) -> None:
    assert bench.connected().wait(3600).over == 0


def test_data_go_to_the_network_a_little_ahead_of_the_carrier(bench: Bench) -> None:
    bench.connected().modem.pump.send(bytes(240))  # 200 ms with 8 bits each
    assert len(b"".join(message for message in bench.link.take() if isinstance(message, bytes))) == 24
    bench.clock.advance_to(bench.clock.now_ns() + 100 * MS)
    sent = len(b"".join(message for message in bench.link.take() if isinstance(message, bytes)))
    assert 24 + sent == pytest.approx(144, abs=13)


def test_a_modem_that_is_not_ready_stops_the_data(bench: Bench) -> None:
    bench.connected().hear(Ready(False)).modem.pump.send(b"data")
    assert bench.link.take() == []
    assert bench.hear(Ready(True)).link.take() == [b"data"]


def test_what_waits_leaves_before_it_hangs_up(bench: Bench) -> None:
    bench.connected().modem.pump.send(bytes(1200))  # one second
    bench.modem.finish()
    bench.wait(0.99)
    assert bench.over == 0
    bench.wait(0.1)
    assert bench.over == 1
    sent = bench.link.take()
    assert sent[-1] == Hook(False)
    assert sum(len(message) for message in sent if isinstance(message, bytes)) == 1200


def test_after_a_call_the_next_one_is_possible(bench: Bench) -> None:
    bench.connected().hear(b"old", Heard(Tone.BUSY))
    assert (bench.data, bench.over) == (b"old", 1)
    bench.hear(b"lost")
    assert bench.connected().hear(b"new").data == b"oldnew"
