"""The messages in the trace of a bus of wires: signals, and the notes of faults."""

from typing import Any

from fieldrig.faults import note
from fieldrig.faults.note import FaultNote
from fieldrig_bus.signals import codec
from fieldrig_bus.signals.signal import Signal


def encode(message: Signal | FaultNote) -> bytes:
    return note.encode(message) if isinstance(message, FaultNote) else codec.encode(message)


def decode(data: bytes) -> Any:
    """The inverse of `encode`.  ValueError for anything else."""
    return note.decode(data) if data.startswith(note.LEAD) else codec.decode(data)


def show(message: Signal | FaultNote) -> str:
    return note.show(message) if isinstance(message, FaultNote) else codec.show(message)
