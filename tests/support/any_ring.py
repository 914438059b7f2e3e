"""A ring of any kind in virtual time and over processes, with four stations, for suites that ask all kinds the same.

Each station answers every cycle: `belt` in a process of its own, `lift` and `knife` in a rack, `door` in the master's;
as far as a bus can tell one process from another.
"""

import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from direct_bench import At
from hub_bench import LoopBench

from fieldrig.bus import Bus, Delivery, ModelBus
from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.link import Link
from fieldrig.loop.real_clock import RealClock
from fieldrig.loop.threaded_loop import ThreadedLoop
from fieldrig.virtual.rig import Rig
from fieldrig_bus.ring.transport.bus import StarBus
from fieldrig_bus.ring.transport.centre import Centre

MASTER = "max4"
RACKS = {"belt": "belt", "lift": "rack", "knife": "rack", "door": MASTER}
ADDRESSES = {"belt": 3, "lift": 1, "knife": 2, "door": 4}


class MasterOfAny(Protocol):
    """The master of a ring in a test."""

    heard: list[Any]

    def begin(self) -> None:
        """Begin a cycle."""


class StationOfAny(Protocol):
    """A station of a ring in a test, which answers every cycle that it hears."""

    link: Link[Any]
    address: int
    heard: list[Any]


Ma = TypeVar("Ma", bound=MasterOfAny)
St = TypeVar("St", bound=StationOfAny)


class Parts(NamedTuple, Generic[Ma, St]):
    """The parts of a kind of ring that a bench needs."""

    kind: str
    """Its kind in virtual time."""
    make_virtual: Callable[[Mapping[str, Any]], ModelBus[Any]]
    """Makes the bus of that kind, called ring0, from settings."""
    master: Callable[[Link[Any]], Ma]
    station: Callable[[Link[Any], int], St]
    encode: Callable[[Any], bytes]


class AnyRing(Protocol[Ma, St]):
    stations: dict[str, St]
    master: Ma

    @property
    def trace(self) -> list[tuple[str, bytes]]:
        """Senders and messages."""

    def cycle(self) -> Any:
        """Run one whole cycle, including the time in which every station answers.  Returns what the master hears."""

    def join(self, name: str, address: int) -> St: ...

    def observe(self, name: str) -> list[Any]: ...

    def fault(self, **fault: Any) -> int: ...

    def clear(self, number: int) -> None: ...

    def faults(self) -> Mapping[int, Mapping[str, Any]]: ...

    def statistics(self) -> dict[str, float]: ...


R = TypeVar("R", bound=AnyRing[Any, Any])


def last_heard(ring: "AnyRing[Any, Any]") -> dict[str, Any]:
    """Run a cycle, and return what each station hears of it; those that hear nothing are missing."""
    before = {name: len(station.heard) for name, station in ring.stations.items()}
    ring.cycle()
    return {name: station.heard[-1] for name, station in ring.stations.items() if len(station.heard) > before[name]}


def all_joined(ring: R) -> R:
    """Have all stations join the ring, and run a first cycle."""
    for name, address in ADDRESSES.items():
        ring.join(name, address)
    ring.cycle()
    return ring


def run_through(ring: "AnyRing[Any, Any]", faults: Iterable[Mapping[str, Any]]) -> None:
    """Run some cycles with each fault, and one without it."""
    for fault in faults:
        number = ring.fault(**fault)
        for _ in range(6):
            ring.cycle()
        ring.clear(number)
        ring.cycle()


def throw_garbage(star: "StarRing[Any, Any]") -> None:
    """Have the centre and the rack receive bytes that are no message of theirs."""
    for garbage in (b"", b"\0", b"\xff" * 40):
        star.star.take("rack", garbage)
        star.buses["rack"].rack(star.at["knife"]).on_spread(garbage)


class VirtualRing(Generic[Ma, St]):
    def __init__(self, parts: Parts[Ma, St], settings: Mapping[str, Any]) -> None:
        self.trace: list[tuple[str, bytes]] = []
        self._parts = parts
        config = from_dict({"time": "virtual", "seed": 7, "buses": {"ring0": {"kind": parts.kind}}})
        ring = parts.make_virtual(settings)  # stations that it names are in no rig file
        entry = replace(config.buses["ring0"], bus=ring)
        self.rig = Rig(replace(config, buses={"ring0": entry}), self._on_delivery)
        self.master = parts.master(self.rig.attach(MASTER).link("ring0"))
        self.stations: dict[str, St] = {}

    def _on_delivery(self, _bus: Bus[Any], delivery: Delivery[Any]) -> None:
        self.trace.append((delivery.sender, self._parts.encode(delivery.message)))

    def cycle(self) -> Any:
        self.master.begin()
        self.rig.run_until(self.rig.now_ns + 4 * MS)
        return self.master.heard[-1]

    def join(self, name: str, address: int) -> St:
        self.stations[name] = self._parts.station(self.rig.attach(name).link("ring0"), address)
        return self.stations[name]

    def observe(self, name: str) -> list[Any]:
        heard: list[Any] = []
        self.rig.attach(name).link("ring0").on_receive(heard.append)
        return heard

    def fault(self, **fault: Any) -> int:
        return self.rig.add_fault("ring0", fault)

    def clear(self, number: int) -> None:
        self.rig.clear_fault("ring0", number)

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        return self.rig.faults("ring0")

    def statistics(self) -> dict[str, float]:
        return self.rig.statistics("ring0")


class StarAt(At):
    def __init__(self, member: str, clock: RealClock, process: str, run: Path) -> None:
        super().__init__(member, clock)
        self.process, self._run = process, run
        self.members = {MASTER: MASTER, **RACKS}

    def path(self, name: str) -> Path:
        return self._run / name


class StarRing(LoopBench, Generic[Ma, St]):
    def __init__(self, parts: Parts[Ma, St], make: Callable[[], StarBus[Any]], run: Path) -> None:
        super().__init__(ThreadedLoop)
        self._parts, self._make, self._run = parts, make, run
        self.buses: dict[str, StarBus[Any]] = {}
        self._members: dict[str, str] = {}
        self.at: dict[str, StarAt] = {}
        self.stations: dict[str, St] = {}
        self.begin()

    def begin(self) -> None:
        """The master's process starts."""
        self.master = self._parts.master(self.open(MASTER, MASTER))

    @property
    def star(self) -> Centre:
        star = self.buses[MASTER].star
        assert star is not None
        return star

    @property
    def trace(self) -> list[tuple[str, bytes]]:
        return [(sender, self._parts.encode(message)) for sender, message in self.at[MASTER].traced]

    def cycle(self) -> Any:
        self.clock.handle(self.master.begin)
        self.settle()
        return self.master.heard[-1]

    def settle(self) -> None:
        self.pump(lambda: not self.star.awaited())

    def until_there(self, stations: int) -> None:
        self.pump(lambda: self.star.statistics()["stations"] == stations)

    def join(self, name: str, address: int) -> St:
        self.stations[name] = self._parts.station(self.open(name, RACKS.get(name, name)), address)
        self.until_there(len(self.stations))
        return self.stations[name]

    def observe(self, name: str) -> list[Any]:
        heard: list[Any] = []
        self.open(name, name).on_receive(heard.append)
        self.pump(lambda: bool(self.star._ring.observers))
        return heard

    def kill(self, process: str) -> None:
        """Close the sockets, as the system does for a killed process."""
        bus = self.buses.pop(process)
        for name in [name for name, home in self._members.items() if home == process]:
            self.loop.run_until_complete(bus.close(name))
            del self._members[name]
            self.stations.pop(name, None)

    def fault(self, **fault: Any) -> int:
        return self.star.add_fault(fault)

    def clear(self, number: int) -> None:
        self.star.clear_fault(number)

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        return self.star.faults()

    def statistics(self) -> dict[str, float]:
        return self.star.statistics()

    def close(self) -> None:
        for process in tuple(self.buses):
            self.kill(process)
        super().close()

    def open(self, name: str, process: str) -> Link[Any]:
        at = self.at[name] = StarAt(name, self.clock, process, self._run)
        self._members[name] = process
        bus = self.buses.setdefault(process, self._make())
        return self.loop.run_until_complete(bus.open(at))


@contextmanager
def in_virtual_time(parts: Parts[Ma, St], settings: Mapping[str, Any]) -> Iterator[VirtualRing[Ma, St]]:
    ring = VirtualRing(parts, settings)
    with ring.rig:
        yield ring


@contextmanager
def over_processes(parts: Parts[Ma, St], make: Callable[[], StarBus[Any]]) -> Iterator[StarRing[Ma, St]]:
    with tempfile.TemporaryDirectory(prefix="ring") as run, closing(StarRing(parts, make, Path(run))) as ring:
        yield ring
