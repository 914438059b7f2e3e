"""The picture of a rig as data: its devices, its buses with their members, and its wires with their ends.

Everything comes from the loaded rig file, so it stays the same for the life of the rig.  `layout.py` places it.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

from fieldrig.config.entries import BusEntry, DeviceEntry
from fieldrig.config.rig_file import RigConfig
from fieldrig.real.placement import linked_buses
from fieldrig.settings import MASTER, Claim, Settings
from fieldrig_bus.ring.settings import OrderSettings
from fieldrig_bus.wires import WiresVirtual

FEWEST_OF_A_BAR: Final = 3
"""Members of a bus that is drawn as a bar; one with fewer is a cable, and a label on the cards at its ends."""
WIRE: Final = "wire"
"""The `what` of a claim to publish a wire."""


class Shape(StrEnum):
    """How a bus is drawn."""

    RING = "ring"
    BAR = "bar"
    CABLE = "cable"
    WIRES = "wires"


@dataclass(frozen=True, slots=True)
class DevicePart:
    name: str
    kind: str
    process: str
    about: str
    buses: tuple[str, ...]
    logs: tuple[str, ...] = ()
    """Keys of its points that have a message in each line."""


@dataclass(frozen=True, slots=True)
class BusPart:
    name: str
    kind: str
    family: str
    about: str
    shape: Shape
    members: tuple[str, ...]
    """The linked devices; those of a ring in the order of the ring, with its master first."""


@dataclass(frozen=True, slots=True)
class Wire:
    bus: str
    name: str
    publisher: str
    readers: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Graph:
    rig: str
    time: str
    devices: Mapping[str, DevicePart]
    buses: Mapping[str, BusPart]
    wires: tuple[Wire, ...]


def graph_of(config: RigConfig) -> Graph:
    """Return the picture of a rig as data, in the order of its file."""
    return Graph(
        rig=config.name,
        time=config.time,
        devices={name: _device(entry) for name, entry in config.devices.items()},
        buses={name: _bus(entry, config.devices) for name, entry in config.buses.items()},
        wires=tuple(_wires(config)),
    )


def _device(entry: DeviceEntry) -> DevicePart:
    cls = entry.cls
    return DevicePart(entry.name, entry.kind, entry.process, cls.about, linked_buses(entry), tuple(cls.log_keys))


def _bus(entry: BusEntry, devices: Mapping[str, DeviceEntry]) -> BusPart:
    shape, members = _shape(entry), tuple(entry.members)
    settings = entry.bus.settings
    if isinstance(settings, OrderSettings):
        masters = [name for name in members if _is_master(devices[name], entry.name)]
        members = tuple(dict.fromkeys([*masters, *settings.order, *members]))
    return BusPart(entry.name, entry.kind, entry.bus.family, type(entry.bus).about, shape, members)


def _shape(entry: BusEntry) -> Shape:
    if isinstance(entry.bus.settings, OrderSettings):
        return Shape.RING
    if entry.bus.family == WiresVirtual.family:
        return Shape.WIRES
    return Shape.BAR if len(entry.members) >= FEWEST_OF_A_BAR else Shape.CABLE


def _is_master(device: DeviceEntry, bus: str) -> bool:
    return any(
        claim.what == MASTER and bus in _buses_of(claim, device) for claim in device.settings.claims(device.name)
    )


def _buses_of(claim: Claim, device: DeviceEntry) -> tuple[str, ...]:
    buses = device.links.get(claim.link, ())
    return buses if claim.place is None else buses[claim.place : claim.place + 1]


def _wires(config: RigConfig) -> Iterator[Wire]:
    """Yield each wire that a device says it publishes, with the devices whose settings name it.

    A device does not say which wires it reads.  It is taken as a reader if its settings have the name of the wire, or
    if the wire is called DEVICE.SOMETHING after it, which is what wires of plants are called without a setting.
    """
    named = {name: set(texts_of(entry.settings)) for name, entry in config.devices.items()}
    ends: dict[str, list[str]] = defaultdict(list)
    for name, entry in config.devices.items():
        for bus in linked_buses(entry):
            ends[bus].append(name)
    for name, entry in config.devices.items():
        for claim in entry.settings.claims(name):
            if claim.what == WIRE:
                wire = str(claim.value)
                for bus in _buses_of(claim, entry):
                    readers = [
                        other
                        for other in ends[bus]
                        if other != name and (wire in named[other] or wire.startswith(f"{other}."))
                    ]
                    yield Wire(bus, wire, name, tuple(readers))


def texts_of(settings: Settings) -> Iterator[str]:
    """Yield every text in settings, also those that are keys."""
    yield from _texts(settings.model_dump())


def wired_keys(settings: Settings) -> Iterator[str]:
    """Yield the keys in settings that lead to a text, such as the object in `{"6000:01.0": "tank.high"}`."""
    yield from _keys(settings.model_dump())


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield from _texts(key)
            yield from _texts(item)
    elif isinstance(value, list | tuple | set | frozenset):
        for item in value:
            yield from _texts(item)


def _keys(value: Any) -> Iterator[str]:
    if isinstance(value, Mapping):
        for key, item in value.items():
            if isinstance(key, str) and any(True for _ in _texts(item)):
                yield key
            yield from _keys(item)
