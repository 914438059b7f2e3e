"""One ring on every kind of bus that is one, for suites that ask all of them the same.

Four drives answer each cycle with their address and the number of cycles that they have heard: `belt` in a process of
its own, `lift` and `knife` in a rack, `door` in the master's; as far as a bus can tell one process from another.
"""

import tempfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

from direct_bench import At
from hub_bench import LoopBench

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS
from fieldrig.config import from_dict
from fieldrig.link import Link
from fieldrig.real_clock import RealClock
from fieldrig.rig import Rig
from fieldrig.testing import free_port
from fieldrig.threaded_loop import ThreadedLoop
from fieldrig_bus.ring.sercos.message import Answers, Cycle, Mdt, Mst, RingMessage, encode
from fieldrig_bus.ring.sercos.shm import RingShm
from fieldrig_bus.ring.sercos.star import Star
from fieldrig_bus.ring.sercos.star_bus import RingStar, RingStarSettings
from fieldrig_bus.ring.sercos.virtual import RingSettings, RingVirtual
from fieldrig_bus.ring.sercos.zenoh import RingZenoh, RingZenohSettings

MST, MDT = bytes.fromhex("FF 04"), bytes.fromhex("FF 00 C0 00 00")
PROCESSES = {"belt": "belt", "lift": "rack", "knife": "rack", "door": "max4"}
ADDRESSES = {"belt": 3, "lift": 1, "knife": 2, "door": 4}


class Drive:
    def __init__(self, link: Link[RingMessage], address: int) -> None:
        self.link, self.address = link, address
        self.heard: list[RingMessage] = []
        link.on_receive(self.on_message, [["drive", address]])

    def on_message(self, message: RingMessage) -> None:
        self.heard.append(message)
        self.link.send(bytes((self.address, len(self.heard) & 0xFF)))


class Master:
    def __init__(self, link: Link[RingMessage]) -> None:
        self.link = link
        self.heard: list[Answers] = []
        self.number = 0
        link.on_receive(self.on_message, ["master"])

    def begin(self) -> None:
        self.link.send(Mst(self.number, MST))
        self.number += 1

    def on_message(self, message: RingMessage) -> None:
        assert isinstance(message, Answers)
        self.heard.append(message)
        self.link.send(Mdt(MDT))


class Ring(Protocol):
    drives: dict[str, Drive]
    master: Master

    @property
    def trace(self) -> list[tuple[str, bytes]]:
        """Senders and messages."""

    def cycle(self) -> Answers:
        """Run one whole cycle, including the time in which every drive sends its AT."""

    def join(self, name: str, address: int) -> Drive: ...

    def observe(self, name: str) -> list[RingMessage]: ...

    def fault(self, **fault: Any) -> int: ...

    def clear(self, number: int) -> None: ...

    def statistics(self) -> dict[str, float]: ...


def hearing(ring: Ring) -> dict[str, tuple[bool, bool]]:
    """Return the drives that receive MST and MDT of one cycle; others are missing."""
    before = {name: len(drive.heard) for name, drive in ring.drives.items()}
    ring.cycle()
    last = {name: drive.heard[-1] for name, drive in ring.drives.items() if len(drive.heard) > before[name]}
    return {name: (bool(heard.mst), bool(heard.mdt)) for name, heard in last.items() if isinstance(heard, Cycle)}


class VirtualRing:
    def __init__(self, **settings: Any) -> None:
        self.trace: list[tuple[str, bytes]] = []
        config = from_dict({"time": "virtual", "seed": 7, "buses": {"ring0": {"kind": "ring.virtual"}}})
        ring = RingVirtual("ring0", RingSettings(**settings))  # stations that it names are in no rig file
        entry = replace(config.buses["ring0"], bus=ring)
        self.rig = Rig(replace(config, buses={"ring0": entry}), self._on_delivery)
        self.master = Master(self.rig.attach("max4").link("ring0"))
        self.drives: dict[str, Drive] = {}

    def _on_delivery(self, _bus: Bus[Any], delivery: Delivery[Any]) -> None:
        self.trace.append((delivery.sender, encode(delivery.message)))

    def cycle(self) -> Answers:
        self.master.begin()
        self.rig.run_until(self.rig.now_ns + 4 * MS)
        return self.master.heard[-1]

    def join(self, name: str, address: int) -> Drive:
        self.drives[name] = Drive(self.rig.attach(name).link("ring0"), address)
        return self.drives[name]

    def observe(self, name: str) -> list[RingMessage]:
        heard: list[RingMessage] = []
        self.rig.attach(name).link("ring0").on_receive(heard.append)
        return heard

    def fault(self, **fault: Any) -> int:
        return self.rig.add_fault("ring0", fault)

    def clear(self, number: int) -> None:
        self.rig.clear_fault("ring0", number)

    def statistics(self) -> dict[str, float]:
        return self.rig.statistics("ring0")


class StarAt(At):
    def __init__(self, member: str, clock: RealClock, process: str, run: Path) -> None:
        super().__init__(member, clock)
        self.process, self._run = process, run
        self.members = {"max4": "max4", **PROCESSES}

    def path(self, name: str) -> Path:
        return self._run / name


class StarRing(LoopBench):
    def __init__(self, make: Callable[[], RingStar], run: Path) -> None:
        super().__init__(ThreadedLoop)
        self._make, self._run = make, run
        self.buses: dict[str, RingStar] = {}
        self._members: dict[str, str] = {}
        self.at: dict[str, StarAt] = {}
        self.drives: dict[str, Drive] = {}
        self.begin()

    def begin(self) -> None:
        """The master's process starts."""
        self.master = Master(self.open("max4", "max4"))

    @property
    def star(self) -> Star:
        star = self.buses["max4"].star
        assert isinstance(star, Star)
        return star

    @property
    def trace(self) -> list[tuple[str, bytes]]:
        return [(sender, encode(message)) for sender, message in self.at["max4"].traced]

    def cycle(self) -> Answers:
        self.clock.handle(self.master.begin)
        self.settle()
        return self.master.heard[-1]

    def settle(self) -> None:
        self.pump(lambda: not self.star.awaited())

    def until_there(self, stations: int) -> None:
        self.pump(lambda: self.star.statistics()["stations"] == stations)

    def join(self, name: str, address: int) -> Drive:
        self.drives[name] = Drive(self.open(name, PROCESSES.get(name, name)), address)
        self.until_there(len(self.drives))
        return self.drives[name]

    def observe(self, name: str) -> list[RingMessage]:
        heard: list[RingMessage] = []
        self.open(name, name).on_receive(heard.append)
        self.pump(lambda: self.star.is_observed)
        return heard

    def kill(self, process: str) -> None:
        """Close the sockets, as the system does for a killed process."""
        bus = self.buses.pop(process)
        for name in [name for name, home in self._members.items() if home == process]:
            self.loop.run_until_complete(bus.close(name))
            del self._members[name]
            self.drives.pop(name, None)

    def fault(self, **fault: Any) -> int:
        return self.star.add_fault(fault)

    def clear(self, number: int) -> None:
        self.star.clear_fault(number)

    def statistics(self) -> dict[str, float]:
        return self.star.statistics()

    def close(self) -> None:
        for process in tuple(self.buses):
            self.kill(process)
        super().close()

    def open(self, name: str, process: str) -> Link[RingMessage]:
        at = self.at[name] = StarAt(name, self.clock, process, self._run)
        self._members[name] = process
        bus = self.buses.setdefault(process, self._make())
        return self.loop.run_until_complete(bus.open(at))


@contextmanager
def virtual(**settings: Any) -> Iterator[Ring]:
    ring = VirtualRing(**settings)
    with ring.rig:
        yield ring


@contextmanager
def star(make: Callable[[], RingStar]) -> Iterator[StarRing]:
    with tempfile.TemporaryDirectory(prefix="ring") as run, closing(StarRing(make, Path(run))) as ring:
        yield ring


def shm(**settings: Any) -> AbstractContextManager[StarRing]:
    return star(lambda: RingShm("ring0", RingStarSettings(**settings)))


def zenoh(**settings: Any) -> AbstractContextManager[StarRing]:
    return star(lambda: RingZenoh("ring0", RingZenohSettings(**settings)))


def zenoh_tcp(**settings: Any) -> AbstractContextManager[StarRing]:
    place = f"tcp/127.0.0.1:{free_port()}"
    return star(lambda: RingZenoh("ring0", RingZenohSettings(endpoint=place, **settings)))


STARS: dict[str, Callable[..., AbstractContextManager[StarRing]]] = {
    "shm": shm,
    "zenoh": zenoh,
    "zenoh, tcp": zenoh_tcp,
}
KINDS: dict[str, Callable[..., AbstractContextManager[Ring]]] = {"virtual": virtual, **STARS}
