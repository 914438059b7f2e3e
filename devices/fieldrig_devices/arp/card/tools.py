"""Commands to copy that reach a card: by its points, its USER port, and as a CANopen node."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fieldrig.bus import Bus
from fieldrig.device import RUN, Tool
from fieldrig_bus.serial.pty import SerialPty
from fieldrig_bus.serial.rfc2217 import SerialRfc2217
from fieldrig_bus.serial.tcp import SerialTcp
from fieldrig_devices.arp.can.face import EDS
from fieldrig_devices.arp.card.settings import ArpSettings
from fieldrig_devices.arp.user_port.server import UserPortSettings
from fieldrig_devices.canopen import node_tools
from fieldrig_devices.canopen.node_settings import CanopenSettings


def lines(name: str, settings: ArpSettings, links: Mapping[str, Bus[Any]]) -> list[Tool]:
    keys = ("state", "error", "program.line", "axis1.position", "axis2.position")
    tools = [Tool("state", f"fieldrig get {' '.join(f'{name}/{key}' for key in keys)}")]
    port = _user_port(links.get("user"))
    if port is not None:
        baud = "" if settings.user_port == UserPortSettings() else f" --baud {settings.user_port.baud}"
        tools.append(Tool("USER port", f"fieldrig arp state --port {port}{baud}"))
    if "can" in links:
        node = CanopenSettings(node_id=settings.can_node_id, eds=EDS, signals={}, objects={})
        tools += node_tools.lines(node, links)[:1]  # it starts by itself
    return tools


def _user_port(bus: Bus[Any] | None) -> str | None:
    """Address of the line, or None if it has none."""
    match bus:
        case SerialPty():
            return str(Path(RUN) / bus.path)
        case SerialTcp() if bus.settings.listen is not None:
            return f"socket://{bus.settings.listen}"
        case SerialRfc2217():
            return f"rfc2217://{bus.settings.listen}"
    return None
