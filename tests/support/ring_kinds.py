"""One SERCOS ring on every kind of bus that is one, for suites that ask all of them the same.

Four drives answer each cycle with their address and the number of cycles that they have heard; `any_ring` has them in
their processes.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

from any_ring import AnyRing, Parts, in_virtual_time, last_heard, over_processes
from any_ring import StarRing as AnyStarRing

from fieldrig.link import Link
from fieldrig.testing import free_port
from fieldrig_bus.ring.sercos.message import Answers, Cycle, Mdt, Mst, RingMessage, encode
from fieldrig_bus.ring.sercos.shm import RingShm
from fieldrig_bus.ring.sercos.star import RingStarSettings
from fieldrig_bus.ring.sercos.virtual import RingSettings, RingVirtual
from fieldrig_bus.ring.sercos.zenoh import RingZenoh, RingZenohSettings

MST, MDT = bytes.fromhex("FF 04"), bytes.fromhex("FF 00 C0 00 00")


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


PARTS = Parts("ring.virtual", lambda settings: RingVirtual("ring0", RingSettings(**settings)), Master, Drive, encode)
Ring = AnyRing[Master, Drive]
StarRing = AnyStarRing[Master, Drive]


def hearing(ring: Ring) -> dict[str, tuple[bool, bool]]:
    """Return the drives that receive MST and MDT of one cycle; others are missing."""
    return {
        name: (bool(heard.mst), bool(heard.mdt)) for name, heard in last_heard(ring).items() if isinstance(heard, Cycle)
    }


def virtual(**settings: Any) -> AbstractContextManager[Ring]:
    return in_virtual_time(PARTS, settings)


def shm(**settings: Any) -> AbstractContextManager[StarRing]:
    return over_processes(PARTS, lambda: RingShm("ring0", RingStarSettings(**settings)))


def zenoh(**settings: Any) -> AbstractContextManager[StarRing]:
    return over_processes(PARTS, lambda: RingZenoh("ring0", RingZenohSettings(**settings)))


def zenoh_tcp(**settings: Any) -> AbstractContextManager[StarRing]:
    place = f"tcp/127.0.0.1:{free_port()}"
    return over_processes(PARTS, lambda: RingZenoh("ring0", RingZenohSettings(endpoint=place, **settings)))


STARS: dict[str, Callable[..., AbstractContextManager[StarRing]]] = {
    "shm": shm,
    "zenoh": zenoh,
    "zenoh, tcp": zenoh_tcp,
}
KINDS: dict[str, Callable[..., AbstractContextManager[Ring]]] = {"virtual": virtual, **STARS}
