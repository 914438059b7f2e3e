"""Devices for the virtual-time benchmark: each answers the frame before it in a ring."""

from fieldrig.device import Device
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.can.frame import CanFrame


class RelaySettings(Settings):
    number: int
    of: int


class Relay(Device):
    """Sends its frame when it hears the one before; `of` of them keep a bus busy with as many frames."""

    def __init__(self, settings: RelaySettings, can: Link[CanFrame]) -> None:
        self._can = can
        self._identifier = 0x100 + settings.number
        before = 0x100 + (settings.number - 1) % settings.of
        can.on_receive(self._on_frame, [[before, 0x7FF]])

    def start(self) -> None:
        self._can.send(CanFrame(self._identifier, bytes(8)))

    def _on_frame(self, frame: CanFrame) -> None:
        self._can.send(CanFrame(self._identifier, frame.data))
