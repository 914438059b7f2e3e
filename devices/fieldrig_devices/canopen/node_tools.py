"""Lines to copy that reach a CANopen node with python canopen."""

import os.path
import shlex
from collections.abc import Mapping
from typing import Any

from fieldrig.bus import Bus
from fieldrig.device import Tool
from fieldrig_devices.canopen.node_settings import CanopenSettings

DEVICE_TYPE, DEVICE_NAME = 0x1000, 0x1008


def lines(settings: CanopenSettings, links: Mapping[str, Bus[Any]]) -> list[Tool]:
    """None if its bus can't be reached by python-can."""
    reach = getattr(links.get("can"), "python_can", None)
    bus = None if reach is None else reach()
    if bus is None:
        return []
    index = DEVICE_NAME if DEVICE_NAME in settings.dictionary() else DEVICE_TYPE
    read = f"print(node.sdo[{index:#06x}].raw)"
    start = "node.nmt.state = 'OPERATIONAL'"
    return [
        Tool("what it is", _python_line(settings, bus, read)),
        Tool("start it", _python_line(settings, bus, start)),
    ]


def _python_line(settings: CanopenSettings, bus: Mapping[str, Any], action: str) -> str:
    """A shell line that does `action` on the node with python canopen."""
    reach = ", ".join(f"{key}={value!r}" for key, value in bus.items())
    steps = [
        "import canopen",
        "n = canopen.Network()",
        f"n.connect({reach})",
        f"node = n.add_node({settings.node_id or 1}, {os.path.relpath(settings.eds)!r})",
        action,
        "n.disconnect()",
    ]
    return f"python -c {_quoted('; '.join(steps))}"


def _quoted(text: str) -> str:
    """For a shell; readable where it can be, as the text has single quotes of its own."""
    return shlex.quote(text) if set(text) & set('"$`\\!') else f'"{text}"'
