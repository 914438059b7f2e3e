"""A device of a rig in this process, to look inside."""

from typing import TypeVar

from fieldrig.device import Device
from fieldrig.virtual.node import LocalNode
from fieldrig.virtual.rig import Rig

D = TypeVar("D", bound=Device)


def device_of(rig: Rig, name: str, kind: type[D]) -> D:
    node = rig._engine.nodes[name]
    assert isinstance(node, LocalNode)
    assert isinstance(node.device, kind)
    return node.device
