"""What the commands of `fieldrig trace` read of a file: the messages of the chosen buses, in the order of time."""

from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from fieldrig.cli import completion
from fieldrig.cli.common import argument
from fieldrig.cli.message_words import bus_of
from fieldrig.cli.names import unfit

if TYPE_CHECKING:
    from fieldrig.traces.trace import TraceEntry

TraceFile = Annotated[Path, argument("FILE", "The trace file.")]
Buses = Annotated[
    list[str] | None,
    argument("[BUS]...", "Only these buses; a * matches any characters.", completion.bus),
]


def survey(file: Path, buses: list[str] | None, wires: list[str] | None = None) -> bool:
    """Read a file once, and return whether its messages are in the order of time.

    UsageError for a bus or wire that the file does not have.
    """
    from fieldrig.traces.trace_files import read

    last_ns, is_in_order, found_buses, named = 0, True, dict[str, None](), dict[str, None]()
    for entry in read(file):
        found_buses[entry.bus] = None
        is_in_order &= entry.time_ns >= last_ns
        last_ns = entry.time_ns
        if wires and (wire := wire_of(entry)) is not None:
            named[wire] = None
    _check_there(buses, list(found_buses), file, "bus")
    _check_there(wires, list(named), file, "wire")
    return is_in_order


def _check_there(patterns: list[str] | None, known: list[str], file: Path, what: str) -> None:
    from fieldrig.errors import UsageError
    from fieldrig.text.nearest import closest

    pattern = unfit(patterns or (), known)
    if pattern is not None:
        raise UsageError(f"{file} has no messages of a {what} {pattern!r}", closest(pattern, known))


def in_order(file: Path, is_in_order: bool, buses: list[str] | None) -> "Iterable[TraceEntry]":
    """Return the messages in the order of time.  A file of several processes need not have it; then it is sorted."""
    from fieldrig.traces.trace_files import read

    entries = chosen(read(file), buses)
    return entries if is_in_order else sorted(entries, key=lambda entry: entry.time_ns)


def chosen(entries: Iterable["TraceEntry"], buses: list[str] | None) -> Iterator["TraceEntry"]:
    for entry in entries:
        if not buses or any(fnmatchcase(entry.bus, pattern) for pattern in buses):
            yield entry


def wire_of(entry: "TraceEntry") -> str | None:
    """Return the name of the wire whose value the message is; None for any other message."""
    from fieldrig.bus import ModelBus

    bus = bus_of(entry.family)
    if not isinstance(bus, ModelBus) or bus.standing_of is None:
        return None
    try:
        wire = bus.standing_of(bus.decode(entry.data))
    except ValueError:
        return None
    return wire if isinstance(wire, str) else None
