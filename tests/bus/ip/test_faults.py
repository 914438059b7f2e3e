"""Each fault of a relay: which bytes and packets arrive, when, and which ends learn that a connection is lost."""

from ipaddress import IPv4Address
from random import Random
from typing import Any

from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import MS
from fieldrig.faults.disturbed import medium_of
from fieldrig.faults.note import FaultNote
from fieldrig_bus.ip import codec
from fieldrig_bus.ip.message import Closed, Ended, IpPacket, KernelOffered, LinkUp, Offered, OnRelay, Opened, Portion
from fieldrig_bus.ip.relay import IpRelay, RelaySettings

ASKS, ANSWERS = "plc", "server"


class Bench:
    def __init__(self, *faults: dict[str, Any]) -> None:
        self.model: BusModel[OnRelay] = medium_of(
            IpRelay("net", RelaySettings.model_validate({"faults": list(faults)}))
        )
        self.model.begin(0, Random("1/net"))
        for member in (ASKS, ANSWERS):
            self.model.join(member)
            self.model.listen(0, member, None)
        self.trace: list[Delivery[OnRelay]] = []
        self.send(0, Offered((80, 502)), ANSWERS)
        self.send(0, Opened(ASKS, 1, 502))

    def send(self, at_ms: int, message: OnRelay, member: str = ASKS) -> None:
        self.model.submit(at_ms * MS, member, message)
        while (next_ns := self.model.next_ns()) is not None and next_ns <= at_ms * MS:
            self.trace += self.model.collect(next_ns)

    def heard(self, member: str) -> list[tuple[int, OnRelay]]:
        """Return the messages that a member has heard besides offers, each with its time in ms."""
        while (next_ns := self.model.next_ns()) is not None:
            self.trace += self.model.collect(next_ns)
        heard = [(each.time_ns // MS, each.message) for each in self.trace if member in each.receivers]
        return [each for each in heard if not isinstance(each[1], Offered | KernelOffered)]


def data(text: bytes, number: int = 1) -> Portion:
    return Portion(ASKS, number, False, text)


def test_a_refused_connection_is_closed_and_the_service_never_hears_of_it() -> None:
    bench = Bench({"what": "refuse", "port": 502, "count": 1})
    assert bench.heard(ANSWERS) == []
    assert bench.heard(ASKS) == [(0, Closed(ASKS, 1, True, "connection refused"))]
    notes = [each.message for each in bench.trace if isinstance(each.message, FaultNote)]
    assert [codec.show(codec.decode(codec.encode(note))) for note in notes] == ["fault 1: connection refused"]
    bench.send(5, Opened(ASKS, 2, 502))
    assert bench.heard(ANSWERS) == [(5, Opened(ASKS, 2, 502))]


def test_a_port_of_another_number_is_not_refused() -> None:
    bench = Bench({"what": "refuse", "port": 80})
    assert bench.heard(ANSWERS) == [(0, Opened(ASKS, 1, 502))]


def test_a_connection_is_cut_at_its_next_bytes_for_both_ends() -> None:
    bench = Bench({"what": "cut", "nth": 2, "count": 1})
    bench.send(1, data(b"GET"))
    bench.send(2, data(b" / "))
    assert bench.heard(ANSWERS) == [
        (0, Opened(ASKS, 1, 502)),
        (1, data(b"GET")),
        (2, Closed(ASKS, 1, False, "connection cut")),
    ]
    assert bench.heard(ASKS) == [(2, Closed(ASKS, 1, True, "connection cut"))]


def test_late_bytes_are_not_overtaken_by_later_ones_or_the_end() -> None:
    bench = Bench({"what": "delay", "delay_ms": 50, "count": 1})
    bench.send(1, data(b"a"))
    bench.send(2, data(b"b"))
    bench.send(3, Ended(ASKS, 1, False))
    assert bench.heard(ANSWERS)[1:] == [(51, data(b"a")), (51, data(b"b")), (51, Ended(ASKS, 1, False))]


def test_packets_to_a_kernel_are_lost_until_the_fault_ends() -> None:
    bench = Bench({"what": "drop", "duration_ms": 10})
    bench.send(0, KernelOffered(), ANSWERS)
    bench.send(0, LinkUp(ASKS, IPv4Address("10.0.0.1"), IPv4Address("10.0.0.2"), 1500, ()))
    for at_ms in (5, 10):
        bench.send(at_ms, IpPacket(ASKS, False, bytes((at_ms,))))
    assert [at_ms for at_ms, message in bench.heard(ANSWERS) if isinstance(message, IpPacket)] == [10]
