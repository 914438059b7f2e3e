"""Build devices from their entries in a configuration; a device gets what its constructor names, and nothing else."""

from collections.abc import Callable, Iterable, Mapping
from random import Random
from typing import Any

from fieldrig.clock import Clock, VirtualClock
from fieldrig.config.entries import DeviceEntry
from fieldrig.config.kinds import constructor_parameters, link_parameters
from fieldrig.config.rig_file import described
from fieldrig.device import POWER_OFF, Device
from fieldrig.errors import ConfigError, Mistake, RigError
from fieldrig.link import Link, UnconnectedLink
from fieldrig.loop.background import Background, VirtualBackground
from fieldrig.storage.store import MemoryStore, Store

Links = Mapping[str, Link[Any] | list[Link[Any]]]


def random_of(part: str, seed: int) -> Random:
    """Return the random numbers of a device or a bus, which no other part of the rig draws from."""
    return Random(f"{seed}/{part}")


def build_device(
    entry: DeviceEntry,
    *,
    clock: Clock,
    links: Links,
    store: Store,
    random: Random,
    background: Background | None = None,
) -> Device:
    """Return the device.  ConfigError, naming it, if it refuses its settings or the files that they name.

    `random` are its random numbers, see `random_of`.  Without `background` it does its long work as under virtual time.
    """
    offered = {
        **{name: None for name, link in link_parameters(entry.cls).items() if not link.required},
        "clock": clock,
        "name": entry.name,
        "settings": entry.settings,
        "store": store,
        "random": random,
        "background": background or VirtualBackground(clock),
        **links,
    }
    asked = constructor_parameters(entry.cls)
    try:
        device: Device = entry.cls(**{name: offered[name] for name in asked if name in offered})
        device.kind = entry.kind
        for fault in entry.faults:
            if fault.get("what") != POWER_OFF or POWER_OFF in entry.cls.fault_models:
                device.add_fault(fault)
        return device
    except ConfigError:
        raise  # of a file that the settings name; each mistake says where
    except (RigError, ValueError, OSError) as cause:
        raise ConfigError([Mistake(*entry.place, f"devices.{entry.name}", *described(cause))]) from cause


def try_devices(devices: Iterable[DeviceEntry], seed: int = 0) -> list[Mistake]:
    """Build each device once on unconnected links, and return the mistakes that the devices find in their settings."""
    mistakes: list[Mistake] = []
    for entry in devices:
        try:
            build_alone(entry, seed)
        except ConfigError as wrong:
            mistakes += wrong.mistakes
    return list(dict.fromkeys(mistakes))  # one file may be wrong for several devices


def build_alone(entry: DeviceEntry, seed: int = 0) -> Device:
    """Return the device on unconnected links and with an empty memory.  ConfigError as from `build_device`."""
    return build_with(entry, lambda _: UnconnectedLink(), seed)


def build_with(entry: DeviceEntry, end_of: Callable[[str], Link[Any]], seed: int = 0) -> Device:
    """Return the device with an empty memory, and with `end_of` each bus.  ConfigError as from `build_device`."""
    links: dict[str, Link[Any] | list[Link[Any]]] = {
        name: [end_of(bus) for bus in buses] if name in entry.many else end_of(buses[0])
        for name, buses in entry.links.items()
    }
    return build_device(
        entry, clock=VirtualClock(), links=links, store=MemoryStore(), random=random_of(entry.name, seed)
    )
