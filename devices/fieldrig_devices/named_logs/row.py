"""A row of a log: one message, or the messages of one dialogue, by name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from fieldrig.traces.trace import TraceEntry


def _nothing() -> Mapping[str, Any]:
    return {}


@dataclass(slots=True)
class Row:
    """One line of `trace show`."""

    time_ns: int
    """The instant of its first message."""
    bus: str
    family: str
    sender: str
    """The sender of its first message."""
    services: tuple[str, ...]
    """The words for `--service` that choose it."""
    kind: str
    """The service for people, such as `SDO read`."""
    node: str
    """The device that it comes from or goes to."""
    text: str
    entries: tuple[int, ...] = ()
    """The numbers of its messages in the log, from 0; none if the row says that something did not come."""
    end_ns: int | None = None
    """The instant of the last message of a dialogue."""
    data: bytes | None = None
    """The message, or the content that a dialogue has carried."""
    node_ids: tuple[int, ...] = ()
    """CANopen: the nodes that it concerns."""
    identifiers: tuple[int, ...] = ()
    """CAN: its identifiers; bit 31 marks one of 29 bits."""
    unit: int | None = None
    """Modbus: the unit."""
    registers: tuple[tuple[str, int, int], ...] = ()
    """Modbus: space, first address and number of what it reads or writes."""
    details: Callable[[], Mapping[str, Any]] = _nothing
    """Returns what scripts get besides."""

    @property
    def words(self) -> str:
        """The whole of it in one line."""
        return " ".join(filter(None, (self.kind, self.node, self.text)))

    def as_data(self) -> dict[str, Any]:
        """Return the row as plain data, for JSON."""
        found: dict[str, Any] = {
            "time_ns": self.time_ns,
            "bus": self.bus,
            "family": self.family,
            "sender": self.sender,
            "data": None if self.data is None else self.data.hex(),
            "message": self.words,
            "service": self.services[0] if self.services else "",
            "kind": self.kind,
            "node": self.node,
            "entries": list(self.entries),
        }
        if self.end_ns is not None:
            found |= {"end_ns": self.end_ns, "duration_ns": self.end_ns - self.time_ns}
        if self.node_ids:
            found["node_ids"] = list(self.node_ids)
        if self.unit is not None:
            found["unit"] = self.unit
        return {**found, **self.details()}


def row_of(number: int, entry: TraceEntry, services: tuple[str, ...], kind: str, node: str, text: str) -> Row:
    """Return the row of a single message."""
    return Row(
        entry.time_ns, entry.bus, entry.family, entry.sender, services, kind, node, text, (number,), data=entry.data
    )
