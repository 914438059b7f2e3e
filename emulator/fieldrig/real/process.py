"""The part of a rig that one process runs in real time: hubs, ends of buses, devices.

The process opens its hubs first, without waiting for others, then attaches its devices to their buses, then starts
them.  If the process of a hub dies, the devices go on without that bus until the hub is back.
"""

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

from fieldrig.bus import Bus, Delivery, DirectBus, ModelBus
from fieldrig.config.build import build_device, random_of
from fieldrig.config.entries import DeviceEntry
from fieldrig.config.rig_file import RigConfig
from fieldrig.control.armed import Armed
from fieldrig.control.bus_questions import answers_of_bus
from fieldrig.control.end_questions import FaultsOfOneEnd, FaultyEnd, TellingEnd, answers_of_end
from fieldrig.control.messages import Control
from fieldrig.control.notices import Watched
from fieldrig.control.subject import Subject, WaitingSubject
from fieldrig.device import Device
from fieldrig.errors import BusError
from fieldrig.faults.note import FaultNote
from fieldrig.faults.power import loses_power
from fieldrig.faults.signals import driven_on
from fieldrig.faults.waiting import WaitingFaults
from fieldrig.hub.attach import OutsidersLink, RemoteLink
from fieldrig.hub.bus_stream import OnDelivery
from fieldrig.hub.checked_link import CheckedLink
from fieldrig.hub.hub import LocalHub, LocalLink
from fieldrig.link import Link
from fieldrig.loop.pace import Pace, beside_a_cycle
from fieldrig.loop.real_clock import DeviceClock, RealClock
from fieldrig.real.background_process import BackgroundProcesses
from fieldrig.real.far_conditions import ConditionsOfOthers, FarConditions
from fieldrig.real.placement import ProcessPlan, linked_buses
from fieldrig.real.process_points import ProcessPoints
from fieldrig.real.progress import step
from fieldrig.real.switched import Switched
from fieldrig.storage.store import FileStore
from fieldrig.system.own_files import part_of
from fieldrig.text.exception_notes import blame, blamed

log = logging.getLogger(__name__)

SOON_S = 0.01
LATER_S = 0.1


class End:
    """The `Attachment` of one device's end to a direct bus."""

    def __init__(self, member: str, bus: Bus[Any], process: "DeviceProcess") -> None:
        self.clock, self.member = process.clock, member
        self.rig, self.seed = process.config.name, process.config.seed
        self.process, self.members = process.plan.name, process.config.buses[bus.name].members
        self._bus, self._process = bus, process

    def path(self, name: str) -> Path:
        return self._process.path(name)

    def deliver(self, handler: Any, message: Any, instant_ns: int | None = None) -> None:
        try:
            if instant_ns is None:
                self.clock.handle(handler, message)
            else:
                self.clock.handle_at(instant_ns, handler, message)
        except Exception as fault:
            blame(fault, self.member, self._bus.name, self.clock.now_ns())
            raise

    def heard(self, sender: str, message: Any) -> None:
        self._process.heard(self._bus.name, sender, message)

    def note_late(self, late_ns: int) -> None:
        self._process.clock.host.note(late_ns)

    def session(self) -> Any:
        return self._process.control.session

    def serve(self, subject: WaitingSubject) -> None:
        self._process.serve(self._bus.name, Armed(self._bus.name, subject, self._process.waiting))


class DeviceProcess:
    """Everything that one process runs.  Call `open`, `attach` and `start` in this order, and `close` at any time."""

    def __init__(self, config: RigConfig, plan: ProcessPlan, clock: RealClock, control: Control) -> None:
        self.config, self.plan, self.clock, self.control = config, plan, clock, control
        self.hubs: dict[str, LocalHub] = {}
        self.served: dict[str, Subject] = {}
        """The buses that this process answers for: those of its hubs, and direct buses whose centre it hosts."""
        self.devices: dict[str, Switched] = {}
        self.stores: dict[str, FileStore] = {}
        self._listeners: list[tuple[str, OnDelivery]] = []
        """The calls that get the messages of direct buses, each with the name of its bus."""
        self._run = config.run.absolute()
        self._ends: dict[str, dict[str, Link[Any]]] = {}
        self._attachments: list[RemoteLink] = []
        self._faulty_ends: list[tuple[str, FaultyEnd]] = []
        self._telling_ends: list[tuple[str, TellingEnd]] = []
        self._direct: list[tuple[DirectBus[Any], str]] = []
        self._waits: set[asyncio.Task[None]] = set()
        self.background = BackgroundProcesses(clock)
        points = ProcessPoints(plan.name, self.devices, self.hubs, cache(partial(driven_on, config)))
        self._far = FarConditions(plan.name, control)
        self.waiting = WaitingFaults(clock, points, points.tell, self._far)
        """The faults that wait until a point has a value."""
        self._of_others = ConditionsOfOthers(clock, points, points.tell, control)
        self.pace = beside_a_cycle(clock) if self._serves_a_cycle() else Pace(clock)

    def path(self, name: str) -> Path:
        return part_of(self._run, name)

    def _serves_a_cycle(self) -> bool:
        """Return whether a device that this process runs, or whose bus it runs, has a cycle to keep."""
        served = {member for name in self.plan.buses for member in self.config.buses[name].members}
        entries = [entry for name, entry in self.config.devices.items() if name in served | set(self.plan.devices)]
        return any(self.config.buses[name].bus.has_cycle for entry in entries for name in linked_buses(entry))

    @property
    def traced_buses(self) -> list[Bus[Any]]:
        """The buses of its hubs, and the direct buses of its devices."""
        names = dict.fromkeys((*self.plan.buses, *(bus for entry in self._entries() for bus in linked_buses(entry))))
        buses = [self.config.buses[name].bus for name in names]
        return [bus for bus in buses if bus.name in self.hubs or isinstance(bus, DirectBus)]

    def listen(self, bus: str, on_delivery: OnDelivery) -> Callable[[], None]:
        """Call `on_delivery` with every message of a bus of `traced_buses`, until the returned function is called."""
        if bus in self.hubs:
            return self.hubs[bus].on_delivery(on_delivery)
        listener = bus, on_delivery
        self._listeners.append(listener)

        def end() -> None:
            if listener in self._listeners:
                self._listeners.remove(listener)

        return end

    def heard(self, bus: str, sender: str, message: Any) -> None:
        """Add a message of a direct bus to the trace."""
        for listened, on_delivery in tuple(self._listeners):
            if listened == bus:
                on_delivery(Delivery(self.clock.now_ns(), sender, message, ()))

    async def open(self) -> None:
        """Open the hubs with their ports.  BusError if an address is not available."""
        for name in self.plan.buses:
            bus = self.config.buses[name].bus
            assert isinstance(bus, ModelBus)
            step(f"opening {name}")
            hub = LocalHub(bus, self.clock, self._run, seed=self.config.seed, pace=self.pace, waiting=self.waiting)
            await hub.open()
            self.hubs[name] = hub
            self.serve(name, hub)
            self.control.serve(f"condition/{name}/*", self._of_others.answers(name))

    def serve(self, bus: str, subject: Subject) -> None:
        """Answer questions about a bus, instead of what answered them before."""
        if bus not in self.served:
            self.control.serve(f"bus/{bus}/*", lambda verb, message: answers_of_bus(self.served[bus])(verb, message))
        self.served[bus] = subject

    @property
    def watched(self) -> list[Watched]:
        """The buses that it answers for, and the ends of direct buses that take faults or report states."""
        buses = [Watched(name, subject.faults, subject.conditions) for name, subject in self.served.items()]
        ends = [Watched(name, end.injected.faults) for name, end in self._faulty_ends]
        return buses + ends + [Watched(name, dict, partial(self._conditions, end)) for name, end in self._telling_ends]

    def _conditions(self, end: TellingEnd) -> Mapping[str, str]:
        return end.conditions(self.clock.now_ns())

    async def attach(self, patience_s: float) -> None:
        """Open every device's ends of its buses.  BusError if one is not available."""
        ends = [(device.name, bus) for device in self._entries() for bus in linked_buses(device)]
        links = await asyncio.gather(*(self._end(device, bus, patience_s) for device, bus in ends))
        for (device, bus), link in zip(ends, links, strict=True):
            self._ends.setdefault(device, {})[bus] = link

    def start(self) -> None:
        """Build the devices, then power them on in order.  ConfigError if one refuses its settings."""
        for entry in self._entries():
            step(f"building {entry.name}")
            store = self.stores[entry.name] = FileStore(
                self._run / "state" / f"{entry.name}.bin", entry.kind, partial(self._on_store, entry.name)
            )
            ends = self._ends.get(entry.name, {})
            with blamed(entry.name, self.clock.now_ns()):
                self.devices[entry.name] = Switched(
                    entry.name,
                    self.clock,
                    partial(self._built, entry, ends, store),
                    tuple(ends.values()),
                    partial(self.clock.cancel_timers_of, entry.name),
                    self.waiting,
                    partial(self._note, entry, ends),
                )
        for name, device in self.devices.items():
            step(f"starting {name}")
            with blamed(name, self.clock.now_ns()):
                self.clock.handle(device.start)
                self.clock.handle(partial(self._lose_power, name))
        self._far.listen(partial(self.clock.handle, self.waiting.begin))
        for name in self.devices:
            self.control.serve(f"condition/{name}/*", self._of_others.answers(name))
        self.clock.handle(self.waiting.arm_all)

    def _note(self, entry: DeviceEntry, ends: Mapping[str, Link[Any]], fault: FaultNote) -> None:
        """Add a fault of a device to the traces of its buses."""
        for name, link in ends.items():
            if not self.config.buses[name].bus.notes_faults:
                continue
            if isinstance(link, LocalLink | RemoteLink):
                link.note(fault)
            else:
                self.heard(name, entry.name, fault)

    def _lose_power(self, name: str) -> None:
        """Take the power from a device that has none from the start."""
        entry = self.config.devices[name]
        for fault in entry.faults:
            if loses_power(entry.cls, fault):
                self.devices[name].add_fault(fault)

    def _built(self, entry: DeviceEntry, ends: dict[str, Link[Any]], store: FileStore) -> Device:
        return build_device(
            entry,
            clock=DeviceClock(self.clock, entry.name),
            links=_links(entry, ends),
            store=store,
            random=random_of(entry.name, self.config.seed),
            background=self.background.of(entry.name),
        )

    async def close(self) -> None:
        self._far.close()
        for wait in tuple(self._waits):
            wait.cancel()
        while self.devices:
            self.clock.handle(self.devices.popitem()[1].stop)
        self.background.close()
        for link in self._attachments:
            await link.close()
        for bus, member in self._direct:
            await bus.close(member)
        while self.hubs:
            await self.hubs.popitem()[1].close()

    def warn(self, text: str) -> None:
        """Report to the rig what its user should know; `fieldrig up` prints it."""
        self.control.publish(f"warning/{self.plan.name}", {"text": text})

    def _on_store(self, device: str, why: str) -> None:
        remedy = f"make room on the disk of {self._run}"
        self.warn(f"{device} cannot store anything: {why}; {remedy}" if why else f"{device} can store again")

    def _entries(self) -> Sequence[DeviceEntry]:
        return [self.config.devices[name] for name in self.plan.devices]

    async def _end(self, device: str, name: str, patience_s: float) -> Link[Any]:
        step(f"attaching {device} to {name}")
        link = await self._linked(device, name, patience_s)
        step(f"{device} is attached to {name}")
        return link

    async def _linked(self, device: str, name: str, patience_s: float) -> Link[Any]:
        bus = self.config.buses[name].bus
        if name in self.hubs:
            return self.hubs[name].join(device)
        if isinstance(bus, DirectBus):
            link = await bus.open(End(device, bus, self))
            self._direct.append((bus, device))
            if isinstance(link, FaultyEnd):
                end = FaultsOfOneEnd(f"{name} of {device}", link.injected, self.waiting)
                self.control.serve(f"end/{name}/{device}/*", answers_of_end(name, end, self.clock))
                self._faulty_ends.append((name, link))
            if isinstance(link, TellingEnd):
                self._telling_ends.append((name, link))
            return CheckedLink(link, bus, device)
        assert isinstance(bus, ModelBus)
        return await self._attached(bus, device, patience_s)

    async def _attached(self, bus: ModelBus[Any], device: str, patience_s: float) -> RemoteLink:
        def on_lost(reason: str) -> None:
            log.warning("%s: %s; waiting for it to come back", device, reason)
            wait = asyncio.get_running_loop().create_task(_attach_patiently(link, None))
            self._waits.add(wait)
            wait.add_done_callback(self._waits.discard)

        link_class = OutsidersLink if bus.serves_outsiders else RemoteLink
        link = link_class(bus, device, self.clock, self._run, on_lost)
        if isinstance(link, OutsidersLink):
            link.pace = self.pace
        self._attachments.append(link)
        await _attach_patiently(link, patience_s)
        return link


async def _attach_patiently(link: RemoteLink, patience_s: float | None) -> None:
    """Attach, and try again for `patience_s`, then raise BusError; None sets no limit.

    A refusal may only mean that the hub still has our former connection.
    """
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
