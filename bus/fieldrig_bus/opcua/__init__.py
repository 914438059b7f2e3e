"""OPC UA: devices offer trees of nodes, and a server in the process of the bus shows them to any client."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "OpcUaMessage",
]

if TYPE_CHECKING:
    from fieldrig_bus.opcua.message import OpcUaMessage
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_bus.opcua.message": "OpcUaMessage",
        },
    )
