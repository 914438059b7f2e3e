"""The process of each device of a rig file, from the file as it is written.

A device runs in the process that its entry names, else in that of the first line of `processes` that it matches, else
in its own.  No kind is needed for this, so a process that runs a part of a rig learns the homes of all devices without
importing the rest.
"""

from collections.abc import Collection, Iterator, Mapping
from fnmatch import fnmatchcase
from typing import Any

from fieldrig.config.keys import as_tuple
from fieldrig.settings import WrongKey
from fieldrig.text.nearest import closest

Rules = Mapping[str, tuple[str, ...]]
"""Names of buses and patterns of names of devices, by process."""


def rules_of(processes: Any) -> Rules:
    """Return the rules in the value of the key `processes`; none for a value of another type."""
    if not isinstance(processes, Mapping):
        return {}
    return {
        process: as_tuple(words)
        for process, words in processes.items()
        if isinstance(process, str) and all(isinstance(word, str) for word in as_tuple(words))
    }


def homes(rules: Rules, buses: Collection[Any], devices: Mapping[Any, Any]) -> dict[Any, str]:
    """Return the process of each device; the entries may have mistakes."""
    return {name: _own(entry) or _by_rule(rules, buses, str(name), entry) for name, entry in devices.items()}


def home_of_hub(bus: str, own: str | None, members: Collection[str], has_own_process: bool) -> str:
    """Return the process that runs the hub of a model bus: `own`, else that of all its members, else one of its name.

    `members` are the processes of the devices that are linked to the bus.
    """
    if own is not None:
        return own
    used = set(members)
    return used.pop() if len(used) == 1 and not has_own_process else bus


def unmatched(rules: Rules, buses: Collection[Any], devices: Mapping[Any, Any]) -> Iterator[WrongKey]:
    """Yield the words of the rules that no device matches."""
    for process, words in rules.items():
        for word in words:
            if not any(_matches(word, buses, str(name), entry) for name, entry in devices.items()):
                known = [str(name) for name in (*buses, *devices)]
                what = f'no device is on a bus "{word}" or has a name like it'
                yield WrongKey((process,), what, closest(word, known))


def names_of_part(name: str, rules: Rules, buses: Mapping[Any, Any], devices: Mapping[Any, Any]) -> set[str]:
    """Return the devices and buses that the process of this name may run, or that of the device or bus of this name.

    It may be more than it runs: whether a bus without `process` runs with its devices depends on its kind.
    """
    home = homes(rules, buses, devices)
    lodgers = {bus: _lodgers(bus, entry, home, devices) for bus, entry in buses.items()}
    processes = {name, *lodgers.get(name, ())} | ({home[name]} if name in home else set())
    return {
        *(device for device, process in home.items() if process in processes),
        *(bus for bus, homes_of_bus in lodgers.items() if homes_of_bus & processes),
    }


def _lodgers(bus: Any, entry: Any, home: Mapping[Any, str], devices: Mapping[Any, Any]) -> set[str]:
    """Return the processes that may run the hub of a bus."""
    if (own := _own(entry)) is not None:
        return {own}
    used = {home[device] for device, device_entry in devices.items() if bus in linked(device_entry)}
    return {bus, *(used if len(used) == 1 else ())}


def linked(device: Any) -> list[str]:
    """Return the names of the buses in a device's entry as it is written, right or wrong."""
    links = device.get("links") if isinstance(device, dict) else None
    return [bus for names in links.values() for bus in as_tuple(names)] if isinstance(links, dict) else []


def _own(entry: Any) -> str | None:
    process = entry.get("process") if isinstance(entry, dict) else None
    return process if isinstance(process, str) else None


def _by_rule(rules: Rules, buses: Collection[Any], name: str, entry: Any) -> str:
    for process, words in rules.items():
        if any(_matches(word, buses, name, entry) for word in words):
            return process
    return name


def _matches(word: str, buses: Collection[Any], name: str, entry: Any) -> bool:
    return word in linked(entry) if word in buses else fnmatchcase(name, word)
