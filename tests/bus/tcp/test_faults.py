"""Each fault of a bus of TCP services: which bytes a device gets, when, and which connections end."""

from random import Random
from typing import Any

from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import MS
from fieldrig.faults.disturbed import medium_of
from fieldrig.faults.note import FaultNote
from fieldrig_bus.tcp import codec
from fieldrig_bus.tcp.message import Close, Connected, Data, OnTcp
from fieldrig_bus.tcp.model import PORT
from fieldrig_bus.tcp.server import TcpServerBus, TcpSettings


class Bench:
    def __init__(self, *faults: dict[str, Any]) -> None:
        bus: Any = TcpServerBus("net", TcpSettings.model_validate({"faults": list(faults)}))
        self.model: BusModel[OnTcp] = medium_of(bus)
        self.model.begin(0, Random("1/net"))
        for member in (PORT, "plc"):
            self.model.join(member)
            self.model.listen(0, member, ["http"])
        self.trace: list[Delivery[Any]] = []

    def send(self, at_ms: int, message: OnTcp, member: str = PORT) -> None:
        self.model.submit(at_ms * MS, member, message)

    def heard(self, member: str) -> list[tuple[int, Any]]:
        while (next_ns := self.model.next_ns()) is not None:
            self.trace += self.model.collect(next_ns)
        return [(each.time_ns // MS, each.message) for each in self.trace if member in each.receivers]


CONNECTED = Connected(1, "http", "127.0.0.1", "127.0.0.1")


def test_a_refused_connection_is_closed_and_its_device_never_hears_of_it() -> None:
    bench = Bench({"what": "refuse", "service": "http", "count": 1})
    bench.send(0, CONNECTED)
    assert bench.heard("plc") == []
    assert bench.heard(PORT) == [(0, Close(1))]
    notes = [each.message for each in bench.trace if isinstance(each.message, FaultNote)]
    assert [codec.show(codec.decode(codec.encode(note))) for note in notes] == ["fault 1: refused"]


def test_a_connection_is_cut_at_its_next_bytes() -> None:
    bench = Bench({"what": "cut", "nth": 2, "count": 1})
    bench.send(0, CONNECTED)
    for at_ms, data in ((1, b"GET"), (2, b" / ")):
        bench.send(at_ms, Data(1, data))
    assert bench.heard("plc") == [(0, CONNECTED), (1, Data(1, b"GET"))]
    assert bench.heard(PORT) == [(2, Close(1))]


def test_late_bytes_are_not_overtaken() -> None:
    bench = Bench({"what": "delay", "delay_ms": 50, "count": 1})
    bench.send(0, CONNECTED)
    for at_ms, data in ((1, b"a"), (2, b"b"), (80, b"c")):
        bench.send(at_ms, Data(1, data))
    assert bench.heard("plc") == [(0, CONNECTED), (51, Data(1, b"a")), (51, Data(1, b"b")), (80, Data(1, b"c"))]
