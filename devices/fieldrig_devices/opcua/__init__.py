"""The nodes that devices offer to OPC UA clients."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "OpcUaFace",
    "PointsTree",
]

if TYPE_CHECKING:
    from fieldrig_devices.opcua.face import OpcUaFace
    from fieldrig_devices.opcua.points import PointsTree
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.opcua.face": "OpcUaFace",
            "fieldrig_devices.opcua.points": "PointsTree",
        },
    )
