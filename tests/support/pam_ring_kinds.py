"""One ring of a PAM on every kind of bus that is one, for suites that ask all of them the same.

Four nodes answer each cycle that arrives well with a report of the number of cycles that they have heard; `any_ring`
has them in their processes.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

from any_ring import AnyRing, Parts, in_virtual_time, last_heard, over_processes
from any_ring import StarRing as AnyStarRing

from fieldrig.link import Link
from fieldrig_bus.ring.pam.message import GROUP, Cycle, Frames, Reception, Reports, RingMessage, encode
from fieldrig_bus.ring.pam.shm import PamRingShm
from fieldrig_bus.ring.pam.star import PamRingStarSettings
from fieldrig_bus.ring.pam.virtual import PamRingSettings, PamRingVirtual
from fieldrig_bus.ring.pam.zenoh import PamRingZenoh, PamRingZenohSettings
from fieldrig_bus.ring.transport import shm_carrier

FRAMES = ((3, b"\x02"), (0, b"\x01"), (GROUP + 1, b"\x09\x01"))


class Node:
    def __init__(self, link: Link[RingMessage], address: int) -> None:
        self.link, self.address = link, address
        self.heard: list[Cycle] = []
        link.on_receive(self.on_message, [["node", address]])

    def on_message(self, message: RingMessage) -> None:
        assert isinstance(message, Cycle)
        self.heard.append(message)
        if message.reception is Reception.GOOD:
            self.link.send(bytes((1, len(self.heard) & 0xFF)))


class Pam:
    def __init__(self, link: Link[RingMessage]) -> None:
        self.link = link
        self.heard: list[Reports] = []
        self.number = 0
        link.on_receive(self.on_message, ["master"])

    def begin(self) -> None:
        self.link.send(Frames(self.number, FRAMES))
        self.number += 1

    def on_message(self, message: RingMessage) -> None:
        assert isinstance(message, Reports)
        self.heard.append(message)


PARTS = Parts(
    "pamring.virtual", lambda settings: PamRingVirtual("ring0", PamRingSettings(**settings)), Pam, Node, encode
)
PamRing = AnyRing[Pam, Node]
PamStarRing = AnyStarRing[Pam, Node]


def hearing(ring: PamRing) -> dict[str, Reception]:
    """Return how each node receives a cycle; those that hear nothing are missing."""
    return {name: heard.reception for name, heard in last_heard(ring).items()}


def virtual(**settings: Any) -> AbstractContextManager[PamRing]:
    return in_virtual_time(PARTS, settings)


def over_shm(**settings: Any) -> AbstractContextManager[PamStarRing]:
    return over_processes(PARTS, lambda: PamRingShm("ring0", PamRingStarSettings(**settings)))


def over_zenoh(**settings: Any) -> AbstractContextManager[PamStarRing]:
    return over_processes(PARTS, lambda: PamRingZenoh("ring0", PamRingZenohSettings(**settings)))


STARS: dict[str, Callable[..., AbstractContextManager[PamStarRing]]] = {
    **({"shm": over_shm} if shm_carrier.is_available() else {}),
    "zenoh": over_zenoh,
}
KINDS: dict[str, Callable[..., AbstractContextManager[PamRing]]] = {"virtual": virtual, **STARS}
