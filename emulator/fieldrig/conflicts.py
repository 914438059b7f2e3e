"""Entries of a rig file that are right each by itself, but not together."""

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from fieldrig.settings import Settings
from fieldrig.wording import Finding
from fieldrig.yaml_source import KeyPath, key_text

if TYPE_CHECKING:
    from fieldrig.config import BusEntry, DeviceEntry

ADDRESS = re.compile(r"(?:(?P<scheme>[a-z-]+)(?:://|/))?(?P<host>\[[0-9a-fA-F:.]+\]|[\w.-]*|\*):(?P<port>[0-9]{1,5})")
LOOPBACK = {"localhost": "127.0.0.1", "[::1]": "127.0.0.1"}
ANY_HOST = {"", "*", "0.0.0.0", "[::]"}
OUTGOING = ("connect", "dial", "remote", "peer", "target")
"""A key with one of these in its name says where to go, not where to listen."""
PATHS = {"path", "pty", "port"}
"""Keys whose text names a pty or a device of the system."""

Text = tuple[KeyPath, str]


def conflicts(
    buses: "Mapping[str, BusEntry]",
    devices: "Mapping[str, DeviceEntry]",
    control: str | None,
    written: Mapping[Any, Any] = MappingProxyType({}),
) -> Iterator[Finding]:
    """`written` has the devices as they stand in the file, also those that are wrong in themselves."""
    texts = [found for name, entry in buses.items() for found in _texts(entry.bus.settings, ("buses", name))]
    yield from _same_ports([(("control",), control), *texts] if control is not None else texts)
    yield from _same_paths(texts)
    yield from _same_node_ids(buses, {**written, **devices})
    yield from _wrong_members(buses)


def _same_ports(texts: list[Text]) -> Iterator[Finding]:
    """Two that want to listen on the same port, as far as it can be told from the form of the settings."""
    taken: list[tuple[bool, str, str, KeyPath]] = []
    for path, text in texts:
        match = ADDRESS.fullmatch(text)
        if match is None or int(match["port"]) == 0:
            continue
        is_udp, host, port = match["scheme"] == "udp", LOOPBACK.get(match["host"], match["host"]), match["port"]
        for other_udp, other_host, other_port, where in taken:
            if (is_udp, port) == (other_udp, other_port) and (host == other_host or ANY_HOST & {host, other_host}):
                yield Finding(path, f"port {port} is taken by {key_text(where)}", "give each a port of its own")
                break
        taken.append((is_udp, host, port, path))


def _same_paths(texts: list[Text]) -> Iterator[Finding]:
    taken: dict[str, KeyPath] = {}
    for path, text in texts:
        if path[-1] in PATHS and taken.setdefault(text, path) != path:
            yield Finding(path, f"{text} is taken by {key_text(taken[text])}", "give each a path of its own")


def _texts(value: Any, path: KeyPath) -> list[Text]:
    """Every text in the settings of a bus that may say where it listens."""
    if isinstance(value, str):
        return [(path, value)]
    if isinstance(value, Settings):
        keys = [key for key in type(value).model_fields if not any(word in key for word in OUTGOING)]
        return [found for key in keys for found in _texts(getattr(value, key), (*path, key))]
    if isinstance(value, list | tuple):
        return [found for index, item in enumerate(value) for found in _texts(item, (*path, index))]
    return []


def _same_node_ids(buses: "Mapping[str, BusEntry]", devices: Mapping[Any, Any]) -> Iterator[Finding]:
    """Two nodes with one number on one CAN bus (CiA 301 has no answer to that)."""
    taken: dict[tuple[str, int], str] = {}
    for name, device in devices.items():
        node_id, linked = _node_of(device)
        for bus in sorted(bus for bus in linked & buses.keys() if buses[bus].bus.family == "can"):
            if type(node_id) is not int:
                continue
            other = taken.setdefault((bus, node_id), name)
            if other != name:
                what = f"node {node_id} on {bus} is {other} already"
                yield Finding(("devices", name, "node_id"), what, "give each node of a bus a number of its own")


def _wrong_members(buses: "Mapping[str, BusEntry]") -> Iterator[Finding]:
    """What buses say of devices that are not theirs."""
    for name, entry in buses.items():
        for wrong in entry.bus.settings.wrong_for([str(member) for member in entry.members]):
            yield Finding(("buses", name, *wrong.path), wrong.what, wrong.remedy)


def _node_of(device: Any) -> tuple[Any, set[Any]]:
    """Its number, if it has one, and the buses that it is linked to."""
    if not isinstance(device, dict):
        return getattr(getattr(device, "settings", None), "node_id", None), _names(getattr(device, "links", None))
    return device.get("node_id"), _names(device.get("links"))


def _names(links: Any) -> set[Any]:
    values = links.values() if isinstance(links, Mapping) else ()
    return {bus for one in values for bus in (one if isinstance(one, list | tuple) else [one]) if isinstance(bus, str)}
