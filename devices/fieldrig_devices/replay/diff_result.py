"""The result of a comparison of two logs."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from fieldrig.traces.trace import TraceEntry


@dataclass(slots=True)
class DiffRow:
    """The differences in one stream: the messages of one identifier, unit, wire or sender."""

    bus: str
    stream: str
    """The identifier in hex on CAN; unit, wire or sender elsewhere."""
    node: str = ""
    """The device by name, as far as an EDS or a rig file says so."""
    kind: str = ""
    """The service, such as `TPDO 1`."""
    left: int = 0
    """Messages of the first log."""
    right: int = 0
    missing: int = 0
    """Messages that only the first log has."""
    more: int = 0
    """Messages that only the second log has."""
    other: int = 0
    """Messages with other data."""
    earlier: int = 0
    """Messages that are earlier in the second log by more than the tolerance."""
    later: int = 0
    most_late_ns: int = 0
    """The largest difference of time, positive if the second log is later."""
    words: str = ""
    """The first message with other data, in words."""

    @property
    def is_same(self) -> bool:
        return not (self.missing or self.more or self.other or self.earlier or self.later)


class FirstDifference(NamedTuple):
    """The earliest difference of two logs."""

    time_ns: int
    """Its instant in the first log."""
    row: DiffRow
    what: str
    """In words."""
    around_left: Sequence["Around"] = ()
    around_right: Sequence["Around"] = ()


class Around(NamedTuple):
    """A message near the first difference."""

    entry: TraceEntry
    time_ns: int
    """Its instant by the clock of the first log."""
    is_it: bool
    """True for the message that differs."""


@dataclass(slots=True)
class DiffResult:
    """The differences of two logs."""

    rows: list[DiffRow]
    """All streams, those with differences first."""
    offset_ns: int
    """The time that was subtracted from those of the second log."""
    first: FirstDifference | None = None
    notes: Sequence[str] = ()
    """Anything that a reader should know, such as that buses have other names."""

    @property
    def is_same(self) -> bool:
        """True if there is no difference."""
        return all(row.is_same for row in self.rows)

    def by(self, name: str) -> list[DiffRow]:
        """Return the sums of the rows by `node` or by `bus`."""
        sums: dict[tuple[str, str], DiffRow] = {}
        for row in self.rows:
            key = (row.bus, row.node if name == "node" else "")
            total = sums.setdefault(key, DiffRow(row.bus, "", row.node if name == "node" else ""))
            _add(total, row)
        return list(sums.values())


def _add(total: DiffRow, row: DiffRow) -> None:
    for name in ("left", "right", "missing", "more", "other", "earlier", "later"):
        setattr(total, name, getattr(total, name) + getattr(row, name))
    total.most_late_ns = max(total.most_late_ns, row.most_late_ns, key=abs)
