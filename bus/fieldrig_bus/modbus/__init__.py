"""Modbus: requests and responses, and the lines that carry them."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "BROADCAST",
    "CONNECTIONS",
    "ClientConnected",
    "LineState",
    "ModbusEvent",
    "ModbusMessage",
    "ModbusRequest",
    "ModbusResponse",
]

if TYPE_CHECKING:
    from fieldrig_bus.modbus.message import (
        BROADCAST,
        CONNECTIONS,
        ClientConnected,
        LineState,
        ModbusEvent,
        ModbusMessage,
        ModbusRequest,
        ModbusResponse,
    )
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_bus.modbus.message": "BROADCAST CONNECTIONS ClientConnected LineState ModbusEvent ModbusMessage"
            " ModbusRequest ModbusResponse",
        },
    )
