"""A ring with its own telegrams, which has nothing of SERCOS, uses the topology and the transports of all rings."""

import asyncio
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import pytest
from any_ring import StarAt
from hub_bench import LoopBench

from fieldrig.bus import Attachment
from fieldrig.faults.note import FaultNote
from fieldrig.link import patience_of
from fieldrig.loop.threaded_loop import ThreadedLoop
from fieldrig_bus.ring.topology import Node, Topology
from fieldrig_bus.ring.transport.bus import Carrier, StarBus, StarSettings
from fieldrig_bus.ring.transport.centre import Centre
from fieldrig_bus.ring.transport.rack import Rack
from fieldrig_bus.ring.transport.shm_carrier import ShmCarrier, is_available
from fieldrig_bus.ring.transport.wire import HEAD
from fieldrig_bus.ring.transport.zenoh import ZenohCarrier

CARRIERS: dict[str, Callable[[], Carrier]] = {"zenoh": lambda: ZenohCarrier("token", None)}
if is_available():
    CARRIERS["shm"] = lambda: ShmCarrier("token")


class Buffered(Node):
    """A node that answers with any bytes."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.telegram = b""

    def lay(self, telegram: bytes) -> None:
        self.telegram = telegram


class TokenRing(Topology[Buffered]):
    """Every node hears a word, and the master gets all answers in the order of the ring."""

    observers: tuple[str, ...] = ()

    def answer_at(self, name: str, addresses: Sequence[int] | None) -> None:
        self.stations[name].addresses = tuple(addresses or ())

    def answers(self) -> list[bytes]:
        return [node.telegram for node in self.layout((), ()).hearing]

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {"nodes": float(len(self.layout((), ()).hearing))}

    def conditions(self, now_ns: int) -> Mapping[str, str]:
        return {}

    def add_fault(self, now_ns: int, fault: Mapping[str, Any]) -> int:
        raise ValueError("this ring takes no faults")

    def begin_fault(self, now_ns: int, number: int) -> None:
        raise ValueError("this ring takes no faults")

    def clear_fault(self, number: int) -> None:
        raise ValueError("this ring takes no faults")

    def all_faults(self, now_ns: int) -> Mapping[int, Mapping[str, Any]]:
        return {}

    def take_notes(self, now_ns: int) -> list[FaultNote]:
        return []


class TokenCentre(Centre):
    def __init__(self, at: Attachment, handler: Callable[[Any], None], loop: asyncio.AbstractEventLoop) -> None:
        self.tokens = TokenRing(Buffered, ["second", "first"], [], [])
        super().__init__("token", at, self.tokens, 0, handler, loop)
        self.tokens.join(at.member)
        self.tokens.master = at.member

    def send(self, message: Any) -> None:
        self.finish(is_repeating=False)
        self._at.deliver(self.handler, self.tokens.answers())
        self.spread(HEAD.pack(self.next_sequence(), self._at.clock.now_ns()) + message.encode())


class TokenRack(Rack[str]):
    def read(self, data: bytes) -> str:
        return data[HEAD.size :].decode()

    def deliver(self, cycle: str, instant_ns: int) -> None:
        for station in self.answering:
            station.at.deliver(station.handler, cycle, instant_ns)


class TokenBus(StarBus[Any]):
    family: ClassVar[str] = "token"
    messages: ClassVar[tuple[type, ...]] = (str, bytes)

    def __init__(self, carrier: Carrier) -> None:
        super().__init__("token", StarSettings(patience_ms=3))
        self.carrier = carrier

    def encode(self, message: Any) -> bytes:
        return str(message).encode()

    def decode(self, data: bytes) -> str:
        return data.decode()

    def show(self, message: Any) -> str:
        return str(message)

    def make_centre(
        self, at: Attachment, handler: Callable[[Any], None], loop: asyncio.AbstractEventLoop
    ) -> TokenCentre:
        return TokenCentre(at, handler, loop)

    def make_rack(self, loop: asyncio.AbstractEventLoop) -> TokenRack:
        return TokenRack(self.name, loop)


class Bench(LoopBench):
    """A master and two nodes, each with an end of the bus as if in a process of its own."""

    def __init__(self, make: Callable[[], Carrier], run: Path) -> None:
        super().__init__(ThreadedLoop)
        self.buses = {name: TokenBus(make()) for name in ("boss", "first", "second")}
        self.links = {
            name: self.loop.run_until_complete(bus.open(StarAt(name, self.clock, name, run)))
            for name, bus in self.buses.items()
        }
        self.answers: list[list[bytes]] = []
        self.words: list[tuple[str, str]] = []
        self.links["boss"].on_receive(self.answers.append, ["master"])
        for address, name in enumerate(("first", "second")):
            self.links[name].on_receive(self._reaction(name), [["node", address]])
        self.pump(lambda: self.centre.statistics()["nodes"] == 2)

    @property
    def centre(self) -> Centre:
        centre = self.buses["boss"].star
        assert centre is not None
        return centre

    def _reaction(self, name: str) -> Callable[[Any], None]:
        def on_word(word: str) -> None:
            self.words.append((name, word))
            self.links[name].send(f"{name} {word}".encode())

        return on_word

    def cycle(self, word: str) -> None:
        self.clock.handle(lambda: self.links["boss"].send(word))
        self.pump(lambda: not self.centre.awaited())

    def close(self) -> None:
        for name, bus in self.buses.items():
            self.loop.run_until_complete(bus.close(name))
        super().close()


@pytest.fixture(params=CARRIERS)
def bench(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    bench = Bench(CARRIERS[request.param], tmp_path_factory.mktemp("r"))
    yield bench
    bench.close()


def test_nodes_hear_the_master_and_answer_in_the_order_of_the_ring(bench: Bench) -> None:
    bench.cycle("go")
    bench.cycle("on")
    bench.cycle("end")
    assert [word for name, word in bench.words if name == "first"] == ["go", "on", "end"]
    assert bench.answers[1:] == [[b"second go", b"first go"], [b"second on", b"first on"]]


def test_a_process_that_is_gone_takes_its_nodes_with_it(bench: Bench) -> None:
    bench.loop.run_until_complete(bench.buses["first"].close("first"))
    bench.pump(lambda: bench.centre.statistics()["nodes"] == 1)


def test_the_ends_of_any_ring_say_how_patient_they_are(bench: Bench) -> None:
    assert patience_of(bench.links["first"]) == 3_000_000
