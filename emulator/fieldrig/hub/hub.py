"""Runs one model bus in real time: members in this process, members in other processes, ports for outside clients.

A hub paces the bus: the model's `next_ns` says when a message has passed, and a timer wakes the hub at that instant.
Each message carries the instant at which its member sent it, so the time to the hub is hidden behind the time on the
medium.  A member may be late by at most `LAG_LIMIT_NS`; beyond that, its message counts as sent now.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from random import Random
from typing import Any

from fieldrig.bus import Delivery, Doors, ModelBus
from fieldrig.clock import MS, Alarm
from fieldrig.errors import refusals
from fieldrig.faults.disturbed import medium_of
from fieldrig.faults.note import FaultNote
from fieldrig.faults.waiting import WaitingFaults
from fieldrig.hub.checked_link import uninteresting, unsendable
from fieldrig.hub.server import HubServer
from fieldrig.link import Link
from fieldrig.loop.pace import Pace
from fieldrig.loop.real_clock import LONGEST_TURN_NS, RealClock
from fieldrig.outside.limits import Reached
from fieldrig.system.own_files import part_of
from fieldrig.text.exception_notes import blame

LAG_LIMIT_NS = 2 * MS


class LocalLink:
    """The end of a member in the hub's own process."""

    def __init__(self, hub: "LocalHub", member: str) -> None:
        self._hub, self._member = hub, member
        self._check = hub.bus.check
        self.handler: Callable[[Any], None] | None = None

    def send(self, message: Any) -> None:
        try:
            self._check(message)
        except (TypeError, ValueError) as cause:
            raise unsendable(cause, self._member, self._hub.bus.name, message) from cause
        self._hub.submit(self._hub.clock.now_ns(), self._member, message)

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        try:
            self._hub.bus.check_interest(interest)
        except (TypeError, ValueError) as cause:
            raise uninteresting(cause, self._member, self._hub.bus.name, interest) from cause
        self.handler = handler
        self._hub.listen(self._member, interest)

    def switch(self, is_on: bool) -> None:
        """Tell the hub that the device of this end has no power, or has it again."""
        self._hub.switch(self._member, is_on)

    def note(self, fault: FaultNote) -> None:
        """Add a fault of the device to the trace of the bus."""
        self._hub.note(self._member, fault)

    def deliver(self, delivery: Delivery[Any]) -> None:
        if self.handler is not None:
            try:
                self._hub.clock.handle_at(delivery.time_ns, self.handler, delivery.message)
            except Exception as fault:
                blame(fault, self._member, self._hub.bus.name, delivery.time_ns)
                raise


class LocalHub:
    def __init__(
        self,
        bus: ModelBus[Any],
        clock: RealClock,
        run: Path,
        seed: int = 0,
        pace: Pace | None = None,
        waiting: WaitingFaults | None = None,
    ) -> None:
        """`pace` is that of this process for what outsiders send; `waiting` holds its faults that wait for a point."""
        self.bus, self.clock = bus, clock
        self._listeners: tuple[Callable[[Delivery[Any]], None], ...] = ()
        self.model = medium_of(bus)
        self.model.begin(clock.now_ns(), Random(f"{seed}/{bus.name}"))
        self._waiting = waiting
        if waiting is not None:
            waiting.know(bus.name, self)
        self._run = run
        self._unpowered: set[str] = set()
        self._members: dict[str, Callable[[Delivery[Any]], None]] = {}
        self._ports: list[Any] = []
        self._server: HubServer | None = None
        self._alarm = Alarm(clock)
        self._is_collecting = False
        self.pace = pace
        self.reached = Reached(bus.name)
        self._crowded: set[object] = set()

    def path(self, name: str) -> Path:
        return part_of(self._run, name)

    def join(self, member: str) -> Link[Any]:
        link = LocalLink(self, member)
        self.join_as(member, link.deliver)
        return link

    def join_as(self, member: str, deliver: Callable[[Delivery[Any]], None]) -> None:
        """Add a member that is called with whole deliveries.  ValueError if the name is taken."""
        if member in self._members:
            raise ValueError(f"{self.bus.name} already has a member {member!r}")
        self._members[member] = deliver
        self.model.join(member)

    def leave(self, member: str) -> None:
        if self._members.pop(member, None) is not None and member not in self._unpowered:
            self.model.leave(member)
        self._unpowered.discard(member)

    def switch(self, member: str, is_on: bool) -> None:
        """Take a member off the medium while its device has no power; it keeps its connection to the hub."""
        if is_on is not (member in self._unpowered):
            return
        if is_on:
            self._unpowered.discard(member)
            self.model.join(member)
        else:
            self._unpowered.add(member)
            self.model.power_lost(self.clock.now_ns(), member)
        self.carry()

    def on_doors(self, call: Callable[[Doors], None]) -> None:
        """Call `call` with the effects of faults on ports."""
        self.model.on_doors(call)

    def on_delivery(self, call: Callable[[Delivery[Any]], None]) -> Callable[[], None]:
        """Call `call` with every message from now on, and every fault that a member notes; return what ends it."""
        self._listeners = (*self._listeners, call)

        def end() -> None:
            self._listeners = tuple(other for other in self._listeners if other is not call)

        return end

    def note(self, member: str, fault: FaultNote) -> None:
        """Add a fault of a member to the trace."""
        self._tell(Delivery(self.clock.now_ns(), member, fault, ()))

    def _tell(self, delivery: Delivery[Any]) -> None:
        for listener in self._listeners:
            listener(delivery)

    def waiting(self, member: str) -> int:
        return self.model.waiting(member) if member in self._members and member not in self._unpowered else 0

    def crowd(self, stream: object, is_crowded: bool) -> None:
        """Note that a member in another process reads more slowly than messages come, or that it has caught up.

        Meanwhile nothing is read from outside, as what comes from there would have to wait in this process.
        """
        before = bool(self._crowded)
        if is_crowded:
            self._crowded.add(stream)
        else:
            self._crowded.discard(stream)
        if before != bool(self._crowded):
            if is_crowded:
                self.reached.note("times outsiders had to wait", "a device has enough to read; outsiders wait")
            for port in self._ports:
                port.hold(is_crowded)

    def listen(self, member: str, interest: Sequence[Any] | None) -> None:
        if member in self._unpowered:
            return
        self.model.listen(self.clock.now_ns(), member, interest)
        self.carry()

    def submit(self, asked_ns: int, member: str, message: Any) -> None:
        self.model.submit(asked_ns, member, message)
        if not self._is_collecting:  # a device that answers while it is called: the loop that called it goes on
            self.carry()

    def submit_late(self, asked_ns: int, member: str, message: Any) -> None:
        """Submit a message of a member whose clock is not trusted beyond `LAG_LIMIT_NS`.  Call `carry` afterwards."""
        if member in self._unpowered:
            return
        now_ns = self.clock.now_ns()
        self.model.submit(min(max(asked_ns, now_ns - LAG_LIMIT_NS), now_ns), member, message)

    def carry(self) -> None:
        """Deliver everything that has arrived by now, and set a timer for the next arrival."""
        if self._is_collecting:
            return
        self._is_collecting = True
        try:
            model, members = self.model, self._members
            next_ns, give_up_ns = model.next_ns(), time.monotonic_ns() + LONGEST_TURN_NS
            while next_ns is not None and next_ns <= (now_ns := self.clock.now_ns()):
                for delivery in model.collect(now_ns):
                    for receiver in delivery.receivers:
                        deliver = members.get(receiver)
                        if deliver is not None:
                            deliver(delivery)
                    self._tell(delivery)
                next_ns = model.next_ns()
                if time.monotonic_ns() > give_up_ns:
                    break
        finally:
            self._is_collecting = False
        self._alarm.at(next_ns, self.carry)

    def statistics(self) -> dict[str, float]:
        figures = self.model.statistics(self.clock.now_ns())
        for port in self._ports:
            figures |= port.statistics()
        if self._server is not None:
            figures |= self._server.statistics()
        return figures | self.reached.figures()

    def signals(self) -> dict[str, dict[str, Any]]:
        return self.bus.signals(self.model.standing(), self.clock.now_ns())

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        """Add a fault of the bus from now on, and return its number.  ControlError for a fault that it refuses."""
        with refusals(self.bus.name):
            number = self.model.add_fault(self.clock.now_ns(), fault)
        if self._waiting is not None:
            self._waiting.arm(self.bus.name, number)
        self.carry()
        return number

    def begin_fault(self, number: int) -> None:
        """Begin a fault that waits for its condition, which is met now."""
        self.model.begin_fault(self.clock.now_ns(), number)
        self.carry()

    def clear_fault(self, number: int) -> None:
        if self._waiting is not None:
            self._waiting.forget(self.bus.name, number)
        with refusals(self.bus.name):
            self.model.clear_fault(self.clock.now_ns(), number)
        self.carry()

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        return self.model.all_faults(self.clock.now_ns())

    def conditions(self) -> Mapping[str, str]:
        return self.model.conditions(self.clock.now_ns())

    async def open(self, serve: bool = True) -> None:
        """Open the ports, and with `serve` the sockets to which devices in other processes attach."""
        try:
            if serve:
                self._server = HubServer(self)
                await self._server.open()
            for port in self.bus.ports():
                self._ports.append(port)
                await port.open(self)
            self.carry()  # a fault from the start may concern the ports
        except BaseException:
            await self.close()
            raise

    async def close(self) -> None:
        self._alarm.stop()
        while self._ports:
            await self._ports.pop().close()
        if self._server is not None:
            await self._server.close()
            self._server = None
