"""Devices with one end of a bus, for tests that send on it by hand."""

from fieldrig.device import Device
from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal


class CanTalker(Device):
    def __init__(self, can: Link[CanFrame]) -> None:
        self.link = can


class WireTalker(Device):
    def __init__(self, wires: Link[Signal]) -> None:
        self.link = wires
