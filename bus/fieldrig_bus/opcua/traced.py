"""The messages in the trace of an OPC UA bus: those of the devices and the server, and those of faults."""

from typing import Any, Final

from fieldrig.faults import note
from fieldrig.faults.note import FaultNote
from fieldrig_bus.opcua import codec
from fieldrig_bus.opcua.message import Hangup, OnOpcUa

HANGUP: Final = b'["Hangup",{}]'


def encode(message: OnOpcUa) -> bytes:
    if isinstance(message, FaultNote):
        return note.encode(message)
    return HANGUP if isinstance(message, Hangup) else codec.encode(message)


def decode(data: bytes) -> Any:
    """The inverse of `encode`.  ValueError for anything else."""
    if data.startswith(note.LEAD):
        return note.decode(data)
    return Hangup() if data == HANGUP else codec.decode(data)


def show(message: OnOpcUa) -> str:
    if isinstance(message, FaultNote):
        return note.show(message)
    return "all connections are closed" if isinstance(message, Hangup) else codec.show(message)
