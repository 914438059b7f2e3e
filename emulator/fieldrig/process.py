"""What one process of a rig runs in real time: hubs, ends of buses, devices.

Opens its hubs first, without waiting for anybody; then attaches its devices to their buses; then starts them.  A hub
that goes away (its process died) is waited for; its devices go on meanwhile, and hear nothing from it.
"""

import asyncio
import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fieldrig.attach import RemoteLink
from fieldrig.build import build_device
from fieldrig.bus import Bus, Delivery, DirectBus, ModelBus
from fieldrig.bus_questions import Subject, answers_of_bus
from fieldrig.bus_stream import OnDelivery
from fieldrig.config import DeviceEntry, RigConfig
from fieldrig.control import Control
from fieldrig.device import Device
from fieldrig.ends import FaultyEnd, answers_of_end
from fieldrig.errors import BusError
from fieldrig.hub import LocalHub
from fieldrig.link import Link
from fieldrig.placement import ProcessPlan, linked_buses
from fieldrig.real_clock import RealClock
from fieldrig.sending import CheckedLink
from fieldrig.store import FileStore

log = logging.getLogger(__name__)

SOON_S = 0.01
LATER_S = 0.1


class End:
    """What a direct bus gets to make one device's end of itself (an `Attachment`)."""

    def __init__(self, member: str, bus: Bus[Any], process: "DeviceProcess") -> None:
        self.clock, self.member = process.clock, member
        self.rig, self.seed = process.config.name, process.config.seed
        self.process, self.members = process.plan.name, process.config.buses[bus.name].members
        self._bus, self._process = bus, process

    def path(self, name: str) -> Path:
        return self._process.path(name)

    def deliver(self, handler: Any, message: Any, instant_ns: int | None = None) -> None:
        if instant_ns is None:
            self.clock.handle(handler, message)
        else:
            self.clock.handle_at(instant_ns, handler, message)

    def heard(self, sender: str, message: Any) -> None:
        self._process.heard(self._bus.name, sender, message)

    def session(self) -> Any:
        return self._process.control.session

    def serve(self, subject: Subject) -> None:
        self._process.serve(self._bus.name, subject)


class DeviceProcess:
    """Call `open`, `attach` and `start` in this order, and `close` at any time."""

    def __init__(self, config: RigConfig, plan: ProcessPlan, clock: RealClock, control: Control) -> None:
        self.config, self.plan, self.clock, self.control = config, plan, clock, control
        self.hubs: dict[str, LocalHub] = {}
        self.served: dict[str, Subject] = {}
        """The buses that this process answers for: its hubs', and direct ones of which it hosts the centre."""
        self.devices: dict[str, Device] = {}
        self._listeners: dict[str, OnDelivery | None] = {}
        self._run = config.run.absolute()
        self._ends: dict[str, dict[str, Link[Any]]] = {}
        self._attachments: list[RemoteLink] = []
        self._direct: list[tuple[DirectBus[Any], str]] = []
        self._waits: set[asyncio.Task[None]] = set()

    def path(self, name: str) -> Path:
        path = self._run / name
        path.parent.mkdir(parents=True, exist_ok=True)
        return path

    @property
    def traced_buses(self) -> list[Bus[Any]]:
        """Those of its hubs, and the direct ones that its devices have ends of."""
        names = dict.fromkeys((*self.plan.buses, *(bus for one in self._entries() for bus in linked_buses(one))))
        buses = [self.config.buses[name].bus for name in names]
        return [bus for bus in buses if bus.name in self.hubs or isinstance(bus, DirectBus)]

    def listen(self, bus: str, on_delivery: OnDelivery | None) -> None:
        """Call it with every message of a bus of `traced_buses`."""
        if bus in self.hubs:
            self.hubs[bus].on_delivery = on_delivery
        else:
            self._listeners[bus] = on_delivery

    def heard(self, bus: str, sender: str, message: Any) -> None:
        """A message of a direct bus, for the trace."""
        on_delivery = self._listeners.get(bus)
        if on_delivery is not None:
            on_delivery(Delivery(self.clock.now_ns(), sender, message, ()))

    async def open(self) -> None:
        """Open the hubs with their ports.  BusError if an address can't be had."""
        for name in self.plan.buses:
            bus = self.config.buses[name].bus
            assert isinstance(bus, ModelBus)
            hub = LocalHub(bus, self.clock, self._run, seed=self.config.seed)
            await hub.open()
            self.hubs[name] = hub
            self.serve(name, hub)

    def serve(self, bus: str, subject: Subject) -> None:
        """Answer questions about a bus; who answered them before doesn't any more."""
        if bus not in self.served:
            self.control.serve(f"bus/{bus}/*", lambda verb, message: answers_of_bus(self.served[bus])(verb, message))
        self.served[bus] = subject

    async def attach(self, patience_s: float) -> None:
        """Get every device's ends of its buses.  BusError if one can't be had."""
        ends = [(device.name, bus) for device in self._entries() for bus in linked_buses(device)]
        links = await asyncio.gather(*(self._end(device, bus, patience_s) for device, bus in ends))
        for (device, bus), link in zip(ends, links, strict=True):
            self._ends.setdefault(device, {})[bus] = link

    def start(self) -> None:
        """Build the devices, then power them on in order.  ConfigError if one finds its settings wrong."""
        for entry in self._entries():
            self.devices[entry.name] = build_device(
                entry,
                clock=self.clock,
                links=_links(entry, self._ends.get(entry.name, {})),
                store=FileStore(self.path(f"state/{entry.name}.bin")),
                seed=self.config.seed,
            )
        for device in self.devices.values():
            self.clock.handle(device.start)

    async def close(self) -> None:
        for wait in tuple(self._waits):
            wait.cancel()
        while self.devices:
            self.clock.handle(self.devices.popitem()[1].stop)
        for link in self._attachments:
            await link.close()
        for bus, member in self._direct:
            await bus.close(member)
        while self.hubs:
            await self.hubs.popitem()[1].close()

    def _entries(self) -> Sequence[DeviceEntry]:
        return [self.config.devices[name] for name in self.plan.devices]

    async def _end(self, device: str, name: str, patience_s: float) -> Link[Any]:
        bus = self.config.buses[name].bus
        if name in self.hubs:
            return self.hubs[name].join(device)
        if isinstance(bus, DirectBus):
            link = await bus.open(End(device, bus, self))
            self._direct.append((bus, device))
            if isinstance(link, FaultyEnd):
                self.control.serve(f"end/{name}/{device}/*", answers_of_end(name, link, self.clock))
            return CheckedLink(link, bus, device)
        assert isinstance(bus, ModelBus)
        return await self._attached(bus, device, patience_s)

    async def _attached(self, bus: ModelBus[Any], device: str, patience_s: float) -> RemoteLink:
        def on_lost(reason: str) -> None:
            log.warning("%s: %s; waiting for it to come back", device, reason)
            wait = asyncio.get_running_loop().create_task(_attach_patiently(link, None))
            self._waits.add(wait)
            wait.add_done_callback(self._waits.discard)

        link = RemoteLink(bus, device, self.clock, self._run, on_lost)
        self._attachments.append(link)
        await _attach_patiently(link, patience_s)
        return link


async def _attach_patiently(link: RemoteLink, patience_s: float | None) -> None:
    """BusError after `patience_s`; None waits for ever.  A refusal may only mean that our old end still stands."""
    loop = asyncio.get_running_loop()
    give_up_s = None if patience_s is None else loop.time() + patience_s
    pause_s = SOON_S
    while True:
        try:
            return await link.connect()
        except BusError as cause:
            if give_up_s is not None and loop.time() > give_up_s:
                raise
            log.debug("%s", cause.what)
        await asyncio.sleep(pause_s)
        pause_s = min(2 * pause_s, LATER_S)


def _links(entry: DeviceEntry, ends: dict[str, Link[Any]]) -> dict[str, Link[Any] | list[Link[Any]]]:
    return {
        parameter: [ends[bus] for bus in buses] if parameter in entry.many else ends[buses[0]]
        for parameter, buses in entry.links.items()
    }
