"""Wires over Zenoh: the signals of `fieldrig_bus.wires` between processes without a hub.

Each signal is published at `fieldrig/<rig>/wires/<bus>/<name>` over the sessions that carry the rig's control messages.
The driver of a wire keeps its value and answers queries with it, so a device that listens later gets the present one.
A driver does not receive its own signals.  Faults act at the end of the driver, on all that it publishes.
Left out: the value of a wire whose driver's process is gone.
"""

import asyncio
import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar
from urllib.parse import quote

import zenoh
from pydantic import Field

from fieldrig.bus import Attachment, Delivery, DirectBus, Time
from fieldrig.faults.disturbed_end import DisturbedEnd
from fieldrig.faults.faults import Fault
from fieldrig.faults.note import FaultNote
from fieldrig.settings import Settings
from fieldrig_bus.signals.codec import decode, encode
from fieldrig_bus.signals.faults import MODELS, Swapped, WireEffects, WireFault
from fieldrig_bus.wires import ALARMS, FAULTS, MOST_WIRES, Alarm, Signal, WiresFamily, WiresModel, alarms_of

log = logging.getLogger(__name__)

ALL = "*"
Handler = Callable[[Signal], None]


class EndEffects(WireEffects):
    """The faults of wires at the end of one driver."""

    knows_all: ClassVar[bool] = False

    def __init__(self, given: Iterable[WireFault], forget: Callable[[str], None]) -> None:
        """`forget` is called with the name of a wire whose value does not stand any more."""
        super().__init__(given)
        self._forget = forget

    def turn(self, fault: Fault[Any], now_ns: int, is_on: bool) -> list[Delivery[Signal]]:
        if isinstance(fault.settings, Swapped):  # a value stood, or will stand, under the name of the other wire
            self._forget(fault.settings.wire)
            self._forget(fault.settings.other)
        return super().turn(fault, now_ns, is_on)


class WiresEnd:
    """One device's end."""

    def __init__(self, at: Attachment, bus: str, settings: "WiresZenohSettings") -> None:
        self._at = at
        self._session: zenoh.Session = at.session()
        self._loop = asyncio.get_running_loop()
        self._place = f"fieldrig/{at.rig}/wires/{bus}"
        self._member = at.member.encode()
        self._present: dict[str, bytes] = {}
        """Signals that this end has published, by key."""
        self._subscribers: list[zenoh.Subscriber[None]] = []
        self._turn = 0  # of the interest; answers for an earlier one are late
        self._queryable = self._session.declare_queryable(f"{self._place}/{ALL}", _directly(self._on_query))
        self._driven = WiresModel(settings.alarms)
        """The signals of the device, before the faults."""
        effects = EndEffects(settings.faults, self._forget_value)
        seed = f"{at.seed}/{bus}/{at.member}"
        self.injected = DisturbedEnd(at.clock, at.member, self._driven, effects, seed, self._publish)
        """The faults of this end."""

    def send(self, message: Signal) -> None:
        self.injected.send(message)

    def switch(self, is_on: bool) -> None:
        """Tell this end that its device has no power, or has it again: without it, digital outputs are off."""
        self.injected.switch(is_on)

    def _publish(self, delivery: Delivery[Signal | FaultNote]) -> None:
        message = delivery.message
        if isinstance(message, Signal):
            key, data = self._key(message.name), encode(message)
            self._present[key] = data
            self._session.put(
                key, data, attachment=self._member, express=True, congestion_control=zenoh.CongestionControl.BLOCK
            )
        self._at.heard(self._at.member, message)

    def on_receive(self, handler: Handler, interest: Sequence[object] | None = None) -> None:
        self._forget_interest()
        turn, heard = self._turn, set[str]()

        def deliver(data: bytes, is_present: bool) -> None:
            """Handle the answer to a query, unless a newer value has been published meanwhile."""
            try:
                signal = decode(data)
            except ValueError as fault:
                log.debug("%s", fault)
                return
            if turn != self._turn or (is_present and (signal.name in heard or len(heard) >= MOST_WIRES)):
                return
            if len(heard) < MOST_WIRES:
                heard.add(signal.name)
            self._at.deliver(handler, signal)

        for key in [self._key(str(name)) for name in interest] if interest is not None else [f"{self._place}/{ALL}"]:
            self._subscribers.append(self._session.declare_subscriber(key, _directly(self._hearing(deliver))))
            self._session.get(
                key,
                _directly(self._asking(deliver)),
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                attachment=self._member,
            )

    def conditions(self, now_ns: int) -> Mapping[str, str]:
        """Return the alarms of the wires that this end drives, so one process reports each."""
        return self._driven.conditions(now_ns)

    def close(self) -> None:
        self.injected.close()
        self._forget_interest()
        _undeclare(self._queryable)

    def _forget_value(self, name: str) -> None:
        self._present.pop(self._key(name), None)

    def _forget_interest(self) -> None:
        self._turn += 1
        while self._subscribers:
            _undeclare(self._subscribers.pop())

    def _key(self, name: str) -> str:
        return f"{self._place}/{quote(name, safe='') or '%'}"

    # The following methods are called by Zenoh's own threads.

    def _hearing(self, deliver: Callable[[bytes, bool], None]) -> Callable[[zenoh.Sample], None]:
        def on_sample(sample: zenoh.Sample) -> None:
            sender = sample.attachment
            if sender is None or sender.to_bytes() != self._member:
                self._loop.call_soon_threadsafe(deliver, sample.payload.to_bytes(), False)

        return on_sample

    def _asking(self, deliver: Callable[[bytes, bool], None]) -> Callable[[zenoh.Reply], None]:
        def on_reply(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                self._loop.call_soon_threadsafe(deliver, reply.ok.payload.to_bytes(), True)

        return on_reply

    def _on_query(self, query: zenoh.Query) -> None:
        with query:
            asker = query.attachment
            if asker is not None and asker.to_bytes() == self._member:
                return
            for key, data in list(self._present.items()):
                if query.key_expr.intersects(key):
                    query.reply(key, data)


class WiresZenohSettings(Settings):
    faults: list[WireFault] = Field(default_factory=list, description=FAULTS)
    alarms: dict[str, Alarm] = Field(default_factory=dict, description=ALARMS)

    def offers(self) -> Iterator[tuple[tuple[str | int, ...], str, str]]:
        yield from alarms_of(self.alarms)


class WiresZenoh(WiresFamily, DirectBus[Signal]):
    about: ClassVar[str] = "signals between devices and plants, in real time over Zenoh, without a hub"
    times: ClassVar[frozenset[Time]] = frozenset({"real"})
    virtual_kind: ClassVar[str | None] = "wires.virtual"
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(self, name: str, settings: WiresZenohSettings) -> None:
        super().__init__(name, settings)
        self._ends: dict[str, WiresEnd] = {}

    async def open(self, at: Attachment) -> WiresEnd:
        end = self._ends[at.member] = WiresEnd(at, self.name, self.settings)
        return end

    async def close(self, member: str) -> None:
        end = self._ends.pop(member, None)
        if end is not None:
            end.close()


def _directly(callback: Callable[[Any], None]) -> "zenoh.handlers.Callback[Any]":
    """A callback on Zenoh's own thread, instead of on a further thread for every declaration."""
    return zenoh.handlers.Callback(callback, indirect=False)


def _undeclare(declared: Any) -> None:
    """Undeclare a subscriber or queryable, for which the stubs have no types."""
    declared.undeclare()
