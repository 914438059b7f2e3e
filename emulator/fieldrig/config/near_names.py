"""Names that are probably mistyped: nothing has them, and something has a name that is nearly the same.

A wire may be driven by hand or by a program outside, so a name that nothing has is no mistake by itself.  Names that
differ only in their numbers, such as `axis1.enable` and `axis2.enable`, are two names.
"""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from fieldrig.config.build import build_with
from fieldrig.config.conflicts import Claimed, claims_of, served, unsure_buses
from fieldrig.config.entries import BusEntry, DeviceEntry
from fieldrig.config.fault_names import named_by
from fieldrig.config.yaml_source import KeyPath, Source, key_text
from fieldrig.errors import ConfigError, Mistake
from fieldrig.link import Link, UnconnectedLink
from fieldrig.settings import WIRE
from fieldrig.text.nearest import is_mistyped, is_slip

OWN_KEYS = frozenset(("kind", "links", "process", "on_exit", "after", "faults"))
"""Keys of a device that name no wires."""


class _Written(NamedTuple):
    """A text that may be the name of a wire which a device reads."""

    device: str
    text: str
    path: KeyPath
    """The key in the rig file; only the device for the name that a wire has by default."""


def near_names(source: Source, buses: Mapping[str, BusEntry], devices: Mapping[str, DeviceEntry]) -> list[Mistake]:
    """Return a doubt about each name that is probably mistyped.

    There are none if the file cannot be read again, such as a pipe.
    """
    if not isinstance(source.data, dict):
        return []
    unsure = unsure_buses(devices)
    sure = {name: entry for name, entry in buses.items() if name not in unsure}
    claims = list(claims_of(buses, devices))
    found = [
        *_of_wires(source, sure, devices, claims),
        *_of_faults(sure, claims),
        *_of_offers(sure, [*claims, *served(devices)]),
        *_of_processes(source.data),
    ]
    return [Mistake(*source.mark(path), key_text(path), what, remedy) for path, what, remedy in dict.fromkeys(found)]


Doubt = tuple[KeyPath, str, str]


def _of_wires(
    source: Source, buses: Mapping[str, BusEntry], devices: Mapping[str, DeviceEntry], claims: Sequence[Claimed]
) -> Iterator[Doubt]:
    for bus in [name for name, entry in buses.items() if entry.bus.family == "wires"]:
        drivers = {str(each.claim.value): each.path for each in claims if each.bus == bus and each.claim.what == WIRE}
        members = {name: device for name, device in devices.items() if bus in device.buses}
        written = [text for device in members.values() for text in _written(source.data, device)]
        used = {each.text for each in written if each.text in drivers and each.device != drivers[each.text][1]}
        suspects = [
            (each, near)
            for each in written
            if each.text not in drivers
            for near in drivers
            if each.path != drivers[near] and _is_slip(each.text, near, is_near_used=near in used)
        ]
        if suspects:
            yield from _judged(bus, suspects, drivers, _readers(bus, members))


def _of_faults(buses: Mapping[str, BusEntry], claims: Sequence[Claimed]) -> Iterator[Doubt]:
    """Yield the wires in the faults of a bus which nothing drives, and which are nearly others."""
    for bus, entry in buses.items():
        drivers = [str(each.claim.value) for each in claims if each.bus == bus and each.claim.what == WIRE]
        for index, fault in enumerate(getattr(entry.bus.settings, "faults", ())):
            for key, what, wire in named_by(fault):
                is_wrong = what == WIRE and wire not in drivers
                near = next((name for name in drivers if is_mistyped(wire, name)), None)
                if is_wrong and near is not None:
                    path = ("buses", bus, "faults", index, key)
                    yield path, f"nothing on {bus} drives {wire}", f"did you mean {near}?"


def _judged(
    bus: str,
    suspects: Sequence[tuple[_Written, str]],
    drivers: Mapping[str, KeyPath],
    readers: Mapping[str, Collection[str]],
) -> Iterator[Doubt]:
    """Yield the suspects that are names of wires which a device reads."""
    for each, near in suspects:
        if each.device not in readers.get(each.text, ()):
            continue
        if not _is_slip(each.text, near, is_near_used=bool(readers.get(near))):
            continue
        if len(each.path) > 2:
            yield (
                each.path,
                f"nothing on {bus} drives {each.text}",
                f"did you mean {near}, as {key_text(drivers[near])}?",
            )
        else:
            remedy = f"did you mean {each.text}, which {each.device} reads?"
            yield drivers[near], f"nothing on {bus} reads {near}", remedy


def _is_slip(word: str, near: str, *, is_near_used: bool) -> bool:
    """Return whether one is probably the other, mistyped; if the other is used by others, it takes more for that."""
    return is_mistyped(word, near, most=1 if is_near_used else None)


def _written(data: Any, device: DeviceEntry) -> Iterator[_Written]:
    """Yield what may be the name of a wire among the settings of a device: texts, and the names by default."""
    entry = data["devices"].get(device.name)
    for key, value in entry.items() if isinstance(entry, dict) else ():
        if key not in OWN_KEYS:
            yield from _texts(device.name, value, ("devices", device.name, key))
    for key in type(device.settings).model_fields:
        if key.endswith("_wire") and getattr(device.settings, key) is None:
            text = f"{device.name}.{key.removesuffix('_wire')}"
            yield _Written(device.name, text, ("devices", device.name))


def _texts(device: str, value: Any, path: KeyPath) -> Iterator[_Written]:
    if isinstance(value, str):
        yield _Written(device, value, path)
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _texts(device, item, (*path, index))
    elif isinstance(value, dict):
        for key, item in value.items():
            if isinstance(key, str):
                yield _Written(device, key, (*path, key))
            yield from _texts(device, item, (*path, key))


class _Listener(UnconnectedLink):
    """An end that keeps what its device wants to hear."""

    def __init__(self) -> None:
        self.names: set[object] = set()

    def on_receive(self, handler: Any, interest: Sequence[object] | None = None) -> None:
        self.names = set(interest or ())


def _readers(bus: str, members: Mapping[str, DeviceEntry]) -> dict[str, set[str]]:
    """Return the devices that read each wire of a bus."""
    readers: dict[str, set[str]] = {}
    for name, entry in members.items():
        ends: list[_Listener] = []
        try:
            build_with(entry, partial(_end, ends, bus)).start()  # some kinds listen from then on
        except ConfigError:
            continue  # a mistake of the device
        for wire in {str(wire) for end in ends for wire in end.names}:
            readers.setdefault(wire, set()).add(name)
    return readers


def _end(ends: list[_Listener], bus: str, name: str) -> Link[Any]:
    if name != bus:
        return UnconnectedLink()
    ends.append(_Listener())
    return ends[-1]


def _of_offers(buses: Mapping[str, BusEntry], claims: Sequence[Claimed]) -> Iterator[Doubt]:
    """Yield what a bus has for a device, or says about it, under a name that no device claims or serves."""
    for bus, entry in buses.items():
        offers = list(entry.bus.settings.offers())
        for path, what, value in offers:
            known = [str(each.claim.value) for each in claims if (each.bus, each.claim.what) == (bus, what)]
            others = {str(other) for _, sort, other in offers if sort == what}
            near = next((name for name in known if is_slip(value, name) and name not in others), None)
            if value not in known and near is not None:
                yield ("buses", bus, *path), f"nothing on {bus} has the {what} {value}", f"did you mean {near}?"


def _of_processes(data: Any) -> Iterator[Doubt]:
    """Yield the process of a single entry that nearly has the name of another process, device or bus."""
    entries = {
        (section, name): entry
        for section in ("buses", "devices")
        for name, entry in (data.get(section) or {}).items()
        if isinstance(entry, dict)
    }
    given = {path: entry["process"] for path, entry in entries.items() if isinstance(entry.get("process"), str)}
    uses = Counter(given.values())
    rules = data.get("processes")
    known = [*(str(name) for _, name in entries), *(rules if isinstance(rules, dict) else ())]
    known += [process for process, count in uses.items() if count > 1]
    for path, process in given.items():
        is_alone = process not in known
        known.append(process)
        if not is_alone:
            continue
        near = next((name for name in known if is_mistyped(process, name)), None)
        if near is not None:
            what = f"nothing else is in the process {process}"
            yield (*path, "process"), what, f"did you mean {near}?"
