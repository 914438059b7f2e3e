"""The processes of a rig under real time, and what each of them runs.

A device runs in the process that its entry names, by default one of its own.  A direct bus needs no process.  A model
bus runs in the process that its entry names; otherwise with its devices, if they all share one process and the kind of
the bus does not need its own (`ModelBus.own_process`); otherwise in a process with the name of the bus.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from fieldrig.bus import ModelBus
from fieldrig.config.entries import BusEntry, DeviceEntry
from fieldrig.config.homes import home_of_hub
from fieldrig.config.keys import OnExit
from fieldrig.config.rig_file import RigConfig, start_order
from fieldrig.errors import RigError
from fieldrig.hub.wire import socket_name


@dataclass(frozen=True, slots=True)
class ProcessPlan:
    name: str
    buses: tuple[str, ...]
    """The model buses whose hubs the process runs."""
    devices: tuple[str, ...]
    """The devices, in the order of starting."""
    attaches: tuple[str, ...]
    """The processes whose hubs its devices attach to; they must be open before its devices start."""
    after: tuple[str, ...]
    """The processes that must be ready before its devices start."""
    on_exit: OnExit


def placement(config: RigConfig) -> dict[str, ProcessPlan]:
    """Return the processes in an order in which they can start.  RigError if they would wait for each other.

    Of a part of a rig (`load_part`), processes may be incomplete, except that of the part.
    """
    hubs = {name: _process_of(entry) for name, entry in config.buses.items() if is_modelled(entry)}
    homes = {name: config.devices[name].process for name in start_order(config)}
    names = dict.fromkeys((*hubs.values(), *homes.values()))
    return _in_order({name: _plan(name, config, hubs, homes) for name in names})


def is_modelled(entry: BusEntry) -> bool:
    return isinstance(entry.bus, ModelBus)


def sockets(config: RigConfig) -> list[str]:
    """Return the names of the Unix sockets of all hubs in the run folder."""
    return [socket_name(entry.bus) for entry in config.buses.values() if is_modelled(entry)]


def linked_buses(device: DeviceEntry) -> tuple[str, ...]:
    """Return every bus that the device is linked to, once."""
    return device.buses


def _process_of(entry: BusEntry) -> str:
    assert isinstance(entry.bus, ModelBus)
    return home_of_hub(entry.name, entry.process, list(entry.members.values()), entry.bus.own_process)


def _plan(name: str, config: RigConfig, hubs: dict[str, str], homes: dict[str, str]) -> ProcessPlan:
    devices = tuple(device for device, home in homes.items() if home == name)
    entries = [config.devices[device] for device in devices]
    return ProcessPlan(
        name=name,
        buses=tuple(bus for bus, hub in hubs.items() if hub == name),
        devices=devices,
        attaches=_others(name, (hubs[bus] for entry in entries for bus in linked_buses(entry) if bus in hubs)),
        after=_others(name, (homes[other] for entry in entries for other in entry.after if other in homes)),
        on_exit=_strictest(entry.on_exit for entry in entries),
    )


def _others(name: str, processes: Iterable[str]) -> tuple[str, ...]:
    return tuple(process for process in dict.fromkeys(processes) if process != name)


def _strictest(choices: Iterable[OnExit]) -> OnExit:
    """Return the setting of a process with several devices.  A hub alone is restarted."""
    asked = set(choices)
    if "stop" in asked:
        return "stop"
    return "ignore" if asked == {"ignore"} else "restart"


def _in_order(plans: dict[str, ProcessPlan]) -> dict[str, ProcessPlan]:
    """Return the processes, each after those it waits for.

    Hubs come first, as a process opens its buses before it waits.
    """
    waiting = dict(sorted(plans.items(), key=lambda item: not item[1].buses))
    ordered: dict[str, ProcessPlan] = {}
    while waiting:
        name = next((name for name, plan in waiting.items() if not set(plan.after) & waiting.keys()), None)
        if name is None:
            raise RigError(
                f"these processes wait for each other: {', '.join(waiting)}",
                "their devices are named in each other's `after`: put them into one process, or remove one `after`",
            )
        ordered[name] = waiting.pop(name)
    return ordered
