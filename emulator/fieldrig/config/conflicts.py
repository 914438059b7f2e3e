"""Conflicts between entries of a rig file that are correct by themselves."""

import re
from collections import defaultdict
from collections.abc import Hashable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, runtime_checkable

from fieldrig.config.entries import BusEntry, DeviceEntry
from fieldrig.config.fault_names import named_in_vain
from fieldrig.config.yaml_source import KeyPath, key_text
from fieldrig.settings import MASTER, Claim, Settings, WrongKey

ADDRESS = re.compile(r"(?:(?P<scheme>[a-z-]+)(?:://|/))?(?P<host>\[[0-9a-fA-F:.]+\]|[\w.-]*|\*):(?P<port>[0-9]{1,5})")
LOOPBACK = {"localhost": "127.0.0.1", "[::1]": "127.0.0.1"}
ANY_HOST = {"", "*", "0.0.0.0", "[::]"}
OUTGOING = ("connect", "dial", "remote", "peer", "target")
"""A key with one of these words in its name is an address to connect to, not one to listen on."""
PATHS = {"path", "pty", "port"}
"""The keys whose text is the path of a pty or of a serial device."""

Text = tuple[KeyPath, str]


def conflicts(
    buses: Mapping[str, BusEntry],
    devices: Mapping[str, DeviceEntry],
    control: str | None,
    written: Mapping[Any, Any] = MappingProxyType({}),
    *,
    is_real: bool = True,
) -> Iterator[WrongKey]:
    """Yield every conflict.

    `written` has the devices as they are in the file, including those with mistakes.  Unless the time `is_real`, a test
    may attach members of any name.
    """
    texts = [text for name, entry in buses.items() for text in _texts(entry.bus.settings, ("buses", name))]
    texts = [(("control",), control), *texts] if control is not None else texts
    yield from _ports_of_chance(texts)
    yield from _same_ports(texts)
    yield from _same_paths(texts)
    claims = list(claims_of(buses, devices, written))
    yield from _claimed_twice(claims)
    yield from _needed_in_vain(buses, devices, written, claims)
    yield from _wrong_members(buses, claims)
    yield from named_in_vain(buses, _owners(claims), unsure_buses(devices, written), is_real=is_real)


def _ports_of_chance(texts: list[Text]) -> Iterator[WrongKey]:
    for path, text in texts:
        match = ADDRESS.fullmatch(text)
        if match is not None and int(match["port"]) == 0:
            yield WrongKey(
                path, "port 0 is a random port that no outside client knows", "expected a port from 1 to 65535"
            )


def _same_ports(texts: list[Text]) -> Iterator[WrongKey]:
    """Yield pairs that would listen on the same port, as far as the form of the settings shows it."""
    taken: list[tuple[bool, str, str, KeyPath]] = []
    for path, text in texts:
        match = ADDRESS.fullmatch(text)
        if match is None or int(match["port"]) == 0:
            continue  # wrong by itself
        is_udp, host, port = match["scheme"] == "udp", LOOPBACK.get(match["host"], match["host"]), match["port"]
        for other_udp, other_host, other_port, where in taken:
            if (is_udp, port) == (other_udp, other_port) and (host == other_host or ANY_HOST & {host, other_host}):
                yield WrongKey(path, f"port {port} is taken by {key_text(where)}", "give each a port of its own")
                break
        taken.append((is_udp, host, port, path))


def _same_paths(texts: list[Text]) -> Iterator[WrongKey]:
    taken: dict[str, KeyPath] = {}
    for path, text in texts:
        if path[-1] in PATHS and taken.setdefault(text, path) != path:
            yield WrongKey(path, f"{text} is taken by {key_text(taken[text])}", "give each a path of its own")


def _texts(value: Any, path: KeyPath) -> list[Text]:
    """Return every text in the settings of a bus that may be a listening address."""
    if isinstance(value, str):
        return [(path, value)]
    if isinstance(value, Settings):
        keys = [key for key in type(value).model_fields if not any(word in key for word in OUTGOING)]
        return [text for key in keys for text in _texts(getattr(value, key), (*path, key))]
    if isinstance(value, list | tuple):
        return [text for index, item in enumerate(value) for text in _texts(item, (*path, index))]
    return []


class Claimed(NamedTuple):
    """A claim of one device on one bus."""

    bus: str
    device: str
    claim: Claim

    @property
    def key(self) -> tuple[str, str, Hashable]:
        return self.bus, self.claim.what, self.claim.value

    @property
    def path(self) -> KeyPath:
        return ("devices", self.device, *self.claim.path)


def claims_of(
    buses: Mapping[str, BusEntry],
    devices: Mapping[str, DeviceEntry],
    written: Mapping[Any, Any] = MappingProxyType({}),
) -> Iterator[Claimed]:
    """Yield everything that devices claim on their buses.

    Only the key `node_id` counts for an entry that is wrong in itself, or whose class states no claims.
    """
    for name in {**written, **devices}:
        device = devices.get(name)
        if device is not None and says_claims(device.settings):
            yield from _on_buses(name, device, device.settings.claims(name))
            continue
        node_id, linked = _node_of(device) if device is not None else _written_node_of(written[name])
        for bus in sorted(bus for bus in linked & buses.keys() if buses[bus].bus.family == "can"):
            if type(node_id) is int:
                yield Claimed(bus, name, Claim("", "node-ID", node_id, ("node_id",)))


def served(devices: Mapping[str, DeviceEntry]) -> Iterator[Claimed]:
    """Yield what devices answer to on their buses, which several may have."""
    for name, device in devices.items():
        yield from _on_buses(name, device, device.settings.serves())


def says_claims(settings: Settings) -> bool:
    """Return whether this kind states its claims."""
    return type(settings).claims is not Settings.claims


def _on_buses(name: str, device: DeviceEntry, stated: Iterator[Claim]) -> Iterator[Claimed]:
    for claim in stated:
        buses = device.links.get(claim.link, ())
        for bus in buses if claim.place is None else buses[claim.place : claim.place + 1]:
            yield Claimed(bus, name, claim)


def _claimed_twice(claims: list[Claimed]) -> Iterator[WrongKey]:
    """Yield node-IDs, addresses and drivers of a wire that are claimed twice."""
    taken: dict[tuple[str, str, Hashable], Claimed] = {}
    for claimed in claims:
        other = taken.setdefault(claimed.key, claimed)
        if other is not claimed:
            what, value = claimed.claim.what, claimed.claim.value
            yield WrongKey(
                claimed.path,
                f"{what} {value} on {claimed.bus} is taken by {key_text(other.path)}",
                f"expected one {what} {value} on a bus",
            )


def _needed_in_vain(
    buses: Mapping[str, BusEntry],
    devices: Mapping[str, DeviceEntry],
    written: Mapping[Any, Any],
    claims: list[Claimed],
) -> Iterator[WrongKey]:
    """Yield needs of a device that no other device on the bus and no outside client can meet.

    A bus with a device whose claims are not known is left out.
    """
    unsure, there = unsure_buses(devices, written), _owners(claims)
    for name, device in devices.items():
        for need in _on_buses(name, device, device.settings.needs(name)):
            entry = buses.get(need.bus)
            if entry is None or need.bus in unsure or there[need.key] - {name}:
                continue
            what, value = need.claim.what, need.claim.value
            if not entry.bus.settings.leads_to(what, value):
                others = {key[2] for key, owners in there.items() if key[:2] == need.key[:2] and owners - {name}}
                yield WrongKey(
                    need.path,
                    f"nothing on {need.bus} has {what} {value}",
                    (f"there are: {', '.join(sorted(map(str, others)))}; " if others else "")
                    + f"name one that is outside the rig in the settings of {need.bus}",
                )


def _wrong_members(buses: Mapping[str, BusEntry], claims: list[Claimed]) -> Iterator[WrongKey]:
    """Yield what the settings of buses say about devices that are not linked to them."""
    for name, entry in buses.items():
        masters = [claimed.device for claimed in claims if claimed.bus == name and claimed.claim.what == MASTER]
        for wrong in entry.bus.settings.wrong_for([str(member) for member in entry.members], masters):
            yield WrongKey(("buses", name, *wrong.path), wrong.what, wrong.remedy)


def unsure_buses(devices: Mapping[str, DeviceEntry], written: Mapping[Any, Any] = MappingProxyType({})) -> set[Any]:
    """Return the buses with a device whose claims are not known."""
    silent = {name for name, device in devices.items() if not says_claims(device.settings)}
    unsure = {bus for name in silent for bus in _node_of(devices[name])[1]}
    return unsure | {
        bus for name, entry in written.items() if name not in devices for bus in _written_node_of(entry)[1]
    }


def _owners(claims: list[Claimed]) -> dict[tuple[str, str, Hashable], set[str]]:
    """Return the devices by what they claim."""
    there: dict[tuple[str, str, Hashable], set[str]] = defaultdict(set)
    for claimed in claims:
        there[claimed.key].add(claimed.device)
    return there


@runtime_checkable
class _Numbered(Protocol):
    """Settings of a device that has a node-ID, perhaps without a claim that says so."""

    @property
    def node_id(self) -> Any: ...


def _node_of(device: DeviceEntry) -> tuple[Any, set[Any]]:
    """Return the node-ID of a device, or None, and the buses that it is linked to."""
    return device.settings.node_id if isinstance(device.settings, _Numbered) else None, _names(device.links)


def _written_node_of(entry: Any) -> tuple[Any, set[Any]]:
    """Return the node-ID and the buses of an entry as it is in the file, right or wrong."""
    return (entry.get("node_id"), _names(entry.get("links"))) if isinstance(entry, dict) else (None, set())


def _names(links: Any) -> set[Any]:
    values = links.values() if isinstance(links, Mapping) else ()
    listed = [names if isinstance(names, list | tuple) else [names] for names in values]
    return {bus for names in listed for bus in names if isinstance(bus, str)}
