"""Logs for tests: of CAN frames by hand, and of rigs in virtual time."""

from collections.abc import Callable, Iterable
from pathlib import Path

from fieldrig import Delivery, Rig, load
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can import CanFrame
from fieldrig_bus.can.codec import encode

MS = 1_000_000


def frame(time_ms: float, identifier: int, data: str = "", sender: str = "", bus: str = "can0") -> TraceEntry:
    """A CAN frame of a log, its data in hex."""
    return TraceEntry(round(time_ms * MS), bus, "can", sender, encode(CanFrame(identifier, bytes.fromhex(data))))


def without_senders(log: Iterable[TraceEntry]) -> list[TraceEntry]:
    """The log as a foreign tool has it, without the senders."""
    return [TraceEntry(entry.time_ns, entry.bus, entry.family, "", entry.data) for entry in log]


def recorded(file: Path, drive: Callable[[Rig], object], *overrides: str) -> list[TraceEntry]:
    """All messages of a rig in virtual time while `drive` runs it."""
    log: list[TraceEntry] = []

    def note(bus: object, delivery: Delivery[object]) -> None:
        entry = rig.buses[bus.name]  # type: ignore[attr-defined]
        log.append(
            TraceEntry(delivery.time_ns, entry.name, entry.family, delivery.sender, entry.encode(delivery.message))
        )

    with Rig(load(file, ("time=virtual", *overrides))) as rig:
        rig.on_delivery(note)
        drive(rig)
    return log
