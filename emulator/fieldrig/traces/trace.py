"""The messages of a rig, with time, bus and sender."""

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

from fieldrig.clock import S

_YEAR_NS: Final = 365 * 24 * 3600 * S


class TraceEntry(NamedTuple):
    """A message of a trace.  Logs have millions, and a tuple is made in half the time of a frozen dataclass."""

    time_ns: int
    """Time of day in a recording; virtual time from the start of the rig in that of a rig in virtual time."""
    bus: str
    family: str
    sender: str
    data: bytes
    """The message, as `Bus.encode` of its bus writes it."""


def is_time_of_day(time_ns: int) -> bool:
    """True if an instant of a trace counts from 1970, and not from the start of a rig in virtual time."""
    return time_ns >= _YEAR_NS


def is_batch(message: Any) -> bool:
    """Return whether a published message is a valid batch of `bus_stream`."""
    match message:
        case {"family": str(), "process": str(), "first": int(), "epoch_ns": int(), "entries": list(entries)}:
            return all(map(_is_entry, entries)) and _tells_backs(message)
    return False


def _tells_backs(batch: Mapping[str, Any]) -> bool:
    """Return whether a batch tells nothing of a rig that went back, or how often and where to."""
    match batch.get("backs", 0), batch.get("back_ns", 0):
        case int(), int():
            return ("backs" in batch) == ("back_ns" in batch)
    return False


def _is_entry(entry: Any) -> bool:
    match entry:
        case [int(), str(), str()]:
            return True
    return False
