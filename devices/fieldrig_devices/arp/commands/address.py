"""The address at which the USER port of a card in a rig is reached from outside."""

from pathlib import Path
from typing import TYPE_CHECKING

from fieldrig.errors import RigError
from fieldrig.text.nearest import closest

if TYPE_CHECKING:
    from fieldrig.config.entries import BusEntry, DeviceEntry
from fieldrig.config.rig_file import RigConfig

PORTS = "serial.pty, serial.tcp with listen, or serial.rfc2217"


def port_in_rig(file: Path, card: str | None) -> tuple[str, int]:
    """Address for `ArpPort.open`, and the baud rate.

    Raises RigError, which says what was expected, without such a port.
    """
    from fieldrig.config.rig_file import load

    config = load(file)
    name = _card(config, card)
    links = config.devices[name].links.get("user", ())
    if not links:
        raise RigError(
            f"the USER port of {name} is not linked to a bus", f"add links: {{user: BUS}}, with a bus of kind {PORTS}"
        )
    bus = config.buses[links[0]]
    return _port(config, bus), bus.bus.settings.baud


def _card(config: "RigConfig", wanted: str | None) -> str:
    cards = [name for name, device in config.devices.items() if _is_card(device)]
    if wanted is None and len(cards) == 1:
        return cards[0]
    if wanted in cards:
        assert wanted is not None
        return wanted
    if not cards:
        raise RigError(f"{config.name} has no ARP card", "give the port with --port PORT")
    if wanted is not None:
        raise RigError(f"{config.name} has no ARP card {wanted!r}", closest(wanted, cards))
    raise RigError(f"{config.name} has several ARP cards", f"select a card: --card {' or '.join(cards)}")


def _is_card(device: "DeviceEntry") -> bool:
    from fieldrig_devices.arp.card.card import ArpCard

    return issubclass(device.cls, ArpCard)


def _port(config: "RigConfig", bus: "BusEntry") -> str:
    from fieldrig_bus.serial.pty import SerialPty
    from fieldrig_bus.serial.rfc2217 import SerialRfc2217
    from fieldrig_bus.serial.tcp import SerialTcp

    match bus.bus:
        case SerialPty() as pty:
            return str(config.run.absolute() / pty.path)
        case SerialTcp() as tcp if tcp.settings.listen is not None:
            return f"socket://{_reachable(tcp.settings.listen)}"
        case SerialRfc2217() as rfc2217:
            return f"rfc2217://{_reachable(rfc2217.settings.listen)}"
    raise RigError(f"{bus.name}, a {bus.kind}, is not accessible from outside {config.name}", f"expected {PORTS}")


def _reachable(address: str) -> str:
    """The address from this machine."""
    host, _, port = address.rpartition(":")
    return f"{'127.0.0.1' if host in ('0.0.0.0', '[::]', '') else host}:{port}"
