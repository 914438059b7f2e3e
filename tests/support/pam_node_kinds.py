"""A PAM that only plays a script on its ring, and nodes that keep what they hear: for the ring between processes."""

from typing import Any

from pamring_bench import Pam, PlainNode, third_of_ms

from fieldrig.clock import Clock
from fieldrig.device import Device, Point
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.ring.pam.message import Frames, RingMessage
from fieldrig_devices.pamring.declared import DeclaredNode
from fieldrig_devices.pamring.frames import (
    EndOfPipe,
    Group,
    InputItem,
    NodeType,
    Order,
    Read,
    SetOutput,
    SetPoint,
    SetPointMode,
)
from fieldrig_devices.pamring.settings import RingLimits
from fieldrig_devices.pamring.start_up import Phase

POSITION = SetPointMode.POSITION
CYCLE = RingLimits(thirds=15)
STEPS = 30
"""Cycles of the script."""


def orders_of(step: int) -> list[tuple[int, Order]]:
    """The frames of one cycle of the script: set-points all the time, and now and then something else."""
    orders: list[tuple[int, Order]] = [(address, SetPoint(POSITION, step * address)) for address in (1, 2)]
    if step % 5 == 0:
        orders += [(address, Read(step, address)) for address in (1, 2, 33)]
    if step % 7 == 0:
        orders.append((33, SetOutput(step, step & 1)))
    return orders


class Tap:
    """A link that keeps the frames that pass."""

    def __init__(self, link: Link[RingMessage]) -> None:
        self._link = link
        self.on_receive = link.on_receive
        self.frames: list[str] = []

    def send(self, message: RingMessage) -> None:
        if isinstance(message, Frames):
            self.frames += [f"{target}:{contents.hex()}" for target, contents in message.frames]
        self._link.send(message)


class ScriptedPam(Device):
    def __init__(self, clock: Clock, ring: Link[RingMessage]) -> None:
        self._clock, self._tap = clock, Tap(ring)
        nodes = [DeclaredNode(1, NodeType.ST1, 1, 2), DeclaredNode(2, NodeType.SMART_IO, 33)]
        self._pam = Pam(clock, self._tap, nodes, CYCLE)
        for address in (1, 2, 33):
            self._pam.ring.configure(address, [InputItem(address, 101, 1, True, 1, 1)])
        self._step = 0

    def start(self) -> None:
        self._pam.start()
        self._play()

    def _play(self) -> None:
        """Between two cycles: play a step of the script once the ring runs."""
        ring = self._pam.ring
        if ring.phase is Phase.RUNNING and self._step < STEPS:
            if self._step == 0:
                ring.send(1, Group(4))
                ring.send(2, Group(4))
                ring.send_to_group(4, SetPoint(POSITION, -1))
                ring.send_to_group(4, EndOfPipe(POSITION))
            for address, order in orders_of(self._step):
                ring.send(address, order)
            self._step += 1
        self._clock.call_at(self._clock.now_ns() + third_of_ms(CYCLE.thirds), self._play)

    def points(self) -> dict[str, Point]:
        pam = self._pam
        reports = {
            f"from.{address}": Point(lambda address=address: _lines(r for a, r in pam.reports if a == address))  # type: ignore[misc]  # mypy #12557: a default in a lambda
            for address in (1, 2, 33)
        }
        return {
            "phase": Point(lambda: pam.ring.phase.name),
            "step": Point(lambda: self._step),
            "codes": Point(lambda: " ".join(pam.codes)),
            "sent": Point(lambda: _lines(self._tap.frames)),
            **reports,
        }


class NodeSettings(Settings):
    address: int
    is_smart_io: bool = False


class KeepingNode(Device):
    def __init__(self, clock: Clock, settings: NodeSettings, ring: Link[RingMessage]) -> None:
        self._node = PlainNode(clock, ring, settings.address, NodeType(1 + settings.is_smart_io))

    def points(self) -> dict[str, Point]:
        return {
            "heard": Point(lambda: _lines([*self._node.items, *self._node.orders])),
            "fault": Point(lambda: self._node.end.fault.name),
        }


def _lines(things: Any) -> str:
    return "\n".join(map(str, things))
