"""The part of `fieldrig status` that is the same for every rig, in real and virtual time."""

import os
import time
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

from fieldrig.config.entries import DeviceEntry
from fieldrig.config.rig_file import RigConfig
from fieldrig.control.messages import VERSION, Control
from fieldrig.control.silent_connections import silent_connections


def rig_status(
    config: RigConfig, control: Control, started_s: float, process_of: Callable[[DeviceEntry], str]
) -> dict[str, Any]:
    """Return the common facts.  `started_s` is a time of the monotonic clock."""
    limits, silent = control.limits(), silent_connections(control.session, config.control)
    return {
        "version": VERSION,
        "fieldrig": version("fieldrig"),
        "rig": config.name,
        "file": str(config.path.absolute()),
        "time": config.time,
        "pid": os.getpid(),
        "uptime_s": round(time.monotonic() - started_s, 3),
        **({"limits": {"rig": limits}} if limits else {}),
        **({"silent_connections": silent} if silent else {}),
        "buses": {name: {"kind": entry.kind} for name, entry in config.buses.items()},
        "overrides": list(config.overrides),
        "devices": {
            name: {
                "kind": entry.kind,
                "process": process_of(entry),
                "links": {parameter: list(buses) for parameter, buses in entry.links.items()},
            }
            for name, entry in config.devices.items()
        },
    }


def joined(rig: dict[str, Any], details: dict[str, Any], page: dict[str, Any]) -> dict[str, Any]:
    """Return what `fieldrig status --json` shows: the answer of the rig with those of its processes and its page."""
    if "ui" in rig:
        if reached := page.get("limits"):
            rig.setdefault("client_limits", {})["ui"] = reached
        rig["ui"] |= {key: value for key, value in page.items() if key != "limits"}
    for name, detail in details.items():
        process = rig["processes"].setdefault(name, {"state": detail["state"], "pid": detail["pid"], "restarts": 0})
        process.update(
            {
                key: detail[key]
                for key in ("memory_mb", "own_mb", "cpu_s", "uptime_s", "timers", "late", "troubles")
                if key in detail
            }
        )
        if limits := detail.get("limits"):
            rig.setdefault("limits", {})[name] = limits
        for device, reached in detail.get("client_limits", {}).items():
            if reached:
                rig.setdefault("client_limits", {})[device] = reached
        for bus, statistics in detail["buses"].items():
            rig["buses"].setdefault(bus, {})["statistics"] = statistics
        if stores := detail.get("stores"):  # a device that cannot store works on, but keeps nothing new
            rig.setdefault("stores", {}).update(stores)
            rig["state"] = "degraded" if rig["state"] == "ready" else rig["state"]
    return rig
