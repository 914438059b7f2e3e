"""How to reach the parts of a rig from outside: connections, and shell lines to copy.

The rig answers with its own absolute paths (`help_of`), as only it knows the overrides of its rig file.  The tool that
shows a line makes of it what has to be typed in its folder (`as_typed`).
"""

import os
import re
import shutil
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

from fieldrig.config.entries import DeviceEntry
from fieldrig.config.rig_file import RigConfig
from fieldrig.device import RUN, Tool
from fieldrig.outside.addresses import DEFAULT_ENDPOINT

TALKING: Final = ("status", "watch", "get", "set", "fault", "help")
"""The commands that connect to the control endpoint."""
PACKAGES: Final = {
    "mbpoll": "mbpoll",
    "candump": "can-utils",
    "cansend": "can-utils",
    "slcand": "can-utils",
    "socat": "socat",
    "telnet": "telnet",
    "nc": "netcat-openbsd",
    "curl": "curl",
}
"""The Debian package of each foreign program in the lines."""


class Connection(NamedTuple):
    """One way into one bus, with the devices that a client finds there."""

    bus: str
    protocol: str
    address: str
    devices: list[str]


def connections(config: RigConfig) -> Iterator[Connection]:
    """Yield all connections in the order of the rig file.  A rig in virtual time has none."""
    if config.time == "virtual":
        return
    for name, entry in config.buses.items():
        for way in entry.bus.ways_in(config.run):
            yield Connection(name, way.protocol, way.address, _devices_on(config, name))


def help_of(config: RigConfig, name: str) -> dict[str, Any]:
    """Return what reaches the bus or device, as JSON data.  KeyError if the rig has none of this name."""
    if name in config.buses:
        return {"name": name, "sort": "bus", **_help_of_bus(config, name)}
    return {"name": name, "sort": "device", **_help_of_device(config, config.devices[name])}


def _help_of_bus(config: RigConfig, name: str) -> dict[str, Any]:
    entry, run, is_real = config.buses[name], config.run.absolute(), config.time == "real"
    tools = [*(entry.bus.tools(run) if is_real else ()), Tool("every message", f"fieldrig watch {name}")]
    return {
        "kind": entry.kind,
        "linked": _devices_on(config, name),
        "connections": [way._asdict() for way in (entry.bus.ways_in(run) if is_real else ())],
        "tools": [tool._asdict() for tool in tools],
    }


def _help_of_device(config: RigConfig, device: DeviceEntry) -> dict[str, Any]:
    name, run = device.name, str(config.run.absolute())
    tools = [Tool("all values", f"fieldrig get {name}")]
    if device.cls.fault_models:
        tools.append(Tool("its faults", f"fieldrig fault {name}"))
    if config.time == "real":
        tools += device.cls.tools(name, device.settings, _linked(config, device))
    return {
        "kind": device.kind,
        "linked": list(dict.fromkeys(bus for buses in device.links.values() for bus in buses)),
        "connections": [],
        "tools": [Tool(label, line.replace(RUN, run))._asdict() for label, line in tools],
    }


def _devices_on(config: RigConfig, bus: str) -> list[str]:
    return [name for name, device in config.devices.items() if any(bus in buses for buses in device.links.values())]


def _linked(config: RigConfig, device: DeviceEntry) -> Mapping[str, Any]:
    return {
        parameter: [config.buses[bus].bus for bus in buses] if parameter in device.many else config.buses[buses[0]].bus
        for parameter, buses in device.links.items()
        if buses
    }


def as_typed(line: str, control: str) -> str:
    """Return the line as it has to be typed for this rig, in this folder and with this installation.

    In a shell whose environment is not active, `python` and `fieldrig` may be other programs, or missing.
    """
    program, _, rest = line.partition(" ")
    if program == "fieldrig" and rest.partition(" ")[0] in TALKING and control != DEFAULT_ENDPOINT:
        rest = f"{rest} --control {control}"
    ours = {"python": Path(sys.executable), "fieldrig": Path(sys.executable).with_name("fieldrig")}.get(program)
    path = shutil.which(program)
    if ours is not None and ours.exists() and (path is None or Path(path) != ours):
        program = short(ours)
    return _from_here(f"{program} {rest}".rstrip())


def missing_program(line: str) -> str | None:
    """Return the foreign program that the line needs and this host does not have; None if it can be run."""
    words = line.split()
    program = words[1] if words[0] == "sudo" else words[0]
    return program if program in PACKAGES and shutil.which(program) is None else None


def short(path: Path) -> str:
    """Return the path relative to the current folder if that is shorter."""
    try:
        relative = os.path.relpath(path)
    except ValueError:  # another drive, on Windows
        return str(path)
    return min(relative, str(path.absolute()), key=len)


def _from_here(line: str) -> str:
    """Shorten the absolute paths in a line that lie below the current folder."""
    here = str(Path.cwd())
    return line if here == os.sep else re.sub(rf"(?<![\w.\-/]){re.escape(here)}/", "", line)
