"""The messages of a rig, with time, bus and sender."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class TraceEntry:
    time_ns: int
    """Virtual time from the start of the rig; under real time CLOCK_MONOTONIC."""
    bus: str
    family: str
    sender: str
    data: bytes
    """The message, as `Bus.encode` of its bus writes it."""


def is_batch(message: Any) -> bool:
    """Return whether a published message is a valid batch of `bus_stream`."""
    match message:
        case {"family": str(), "process": str(), "first": int(), "epoch_ns": int(), "entries": list(entries)}:
            return all(map(_is_entry, entries))
    return False


def _is_entry(entry: Any) -> bool:
    match entry:
        case [int(), str(), str()]:
            return True
    return False
