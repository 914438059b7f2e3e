"""Shell lines to copy that reach a CANopen node with python-canopen."""

from collections.abc import Mapping
from typing import Any

from fieldrig.bus import Bus
from fieldrig.device import Tool, python_line
from fieldrig_bus.can.reachable import python_can_of
from fieldrig_devices.canopen.node_settings import CanopenSettings

DEVICE_TYPE, DEVICE_NAME, IDENTITY = 0x1000, 0x1008, 0x1018
FIRST_ID = 127
"""Node-ID that the lines propose for an unconfigured node; the user may choose another."""


def lines(settings: CanopenSettings, links: Mapping[str, Bus[Any]]) -> list[Tool]:
    """Return the lines for a node; none if python-can cannot reach its bus."""
    bus = python_can_of(links.get("can"))
    if bus is None:
        return []
    if settings.node_id is None:
        return [Tool(f"node-ID {FIRST_ID} by LSS", _python_line(bus, _lss(settings)))]
    index = DEVICE_NAME if DEVICE_NAME in settings.dictionary() else DEVICE_TYPE
    node = f"node = n.add_node({settings.node_id}, {str(settings.eds.absolute())!r})"
    return [
        Tool("what it is", _python_line(bus, [node, f"print(node.sdo[{index:#06x}].raw)"])),
        Tool("start it", _python_line(bus, [node, "node.nmt.state = 'OPERATIONAL'"])),
    ]


def _lss(settings: CanopenSettings) -> list[str]:
    """Return steps that select an unconfigured node by its identity, so that several of them may be on the bus."""
    dictionary = settings.dictionary()
    identity = ", ".join(str(dictionary.number(IDENTITY, sub)) for sub in range(1, 5))
    return [
        f"n.lss.send_switch_state_selective({identity})",
        f"n.lss.configure_node_id({FIRST_ID})",
        "n.lss.store_configuration()",
        "n.lss.send_switch_state_global(n.lss.WAITING_STATE)",
    ]


def _python_line(bus: Mapping[str, Any], actions: list[str]) -> str:
    """Return a shell line that performs `actions` on the bus with python-canopen."""
    reach = ", ".join(f"{key}={value!r}" for key, value in bus.items())
    steps = ["import canopen", "n = canopen.Network()", f"n.connect({reach})", *actions, "n.disconnect()"]
    return python_line("; ".join(steps))
