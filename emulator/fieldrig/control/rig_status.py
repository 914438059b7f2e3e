"""The part of `fieldrig status` that is the same for every rig, in real and virtual time."""

import os
import time
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

from fieldrig.config.entries import DeviceEntry
from fieldrig.config.rig_file import RigConfig
from fieldrig.control.messages import VERSION


def rig_status(config: RigConfig, started_s: float, process_of: Callable[[DeviceEntry], str]) -> dict[str, Any]:
    """Return the common facts.  `started_s` is a time of the monotonic clock."""
    return {
        "version": VERSION,
        "fieldrig": version("fieldrig"),
        "rig": config.name,
        "file": str(config.path.absolute()),
        "time": config.time,
        "pid": os.getpid(),
        "uptime_s": round(time.monotonic() - started_s, 3),
        "buses": {name: {"kind": entry.kind} for name, entry in config.buses.items()},
        "devices": {name: {"kind": entry.kind, "process": process_of(entry)} for name, entry in config.devices.items()},
    }
