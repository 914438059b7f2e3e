"""The trace of a scenario in a file, in the formats of `fieldrig trace record`."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fieldrig.bus import Bus, Delivery
from fieldrig.errors import UsageError
from fieldrig.traces.recorder import Recorder

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig


class Trace:
    """A trace that is being written; it takes the batches of buses."""

    def __init__(self, path: Path) -> None:
        """UsageError for an ending without a format, and for a file that cannot be written."""
        self._recorder = Recorder(path)
        self._counts: dict[str, int] = {}
        self.said = ""
        """A summary in words, when it is complete."""

    def take(self, bus: str, batch: Mapping[str, Any]) -> None:
        self._recorder.take(bus, batch)

    def heard(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        """Take a message of a rig in virtual time."""
        first = self._counts.get(bus.name, 0)
        self._counts[bus.name] = first + 1
        entry = [delivery.time_ns, delivery.sender, bus.encode(delivery.message).hex()]
        self.take(bus.name, {"family": bus.family, "process": "", "first": first, "epoch_ns": 0, "entries": [entry]})

    def close(self) -> None:
        """End the file.  UsageError if the disk has refused some of it."""
        self.said = self._recorder.close()
        if self._recorder.taken and not self._recorder.is_whole:
            raise UsageError(self.said)


@contextmanager
def traced(path: Path | None) -> Iterator[Trace | None]:
    """Yield a trace in a file; None without one."""
    if path is None:
        yield None
        return
    trace = Trace(path)
    try:
        yield trace
    finally:
        trace.close()


@contextmanager
def heard_by(rig: "Rig", trace: Trace | None) -> Iterator[None]:
    """Let a trace take all messages of a rig in virtual time."""
    end = None if trace is None else rig.on_delivery(trace.heard)
    try:
        yield
    finally:
        if end is not None:
            end()
