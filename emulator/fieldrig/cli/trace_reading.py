"""The messages of a file that the commands of `fieldrig trace` read: those of the chosen buses, in one reading."""

from collections.abc import Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import argument, duration_ns
from fieldrig.cli.message_words import bus_of
from fieldrig.cli.names import unfit

if TYPE_CHECKING:
    from fieldrig.traces.oddities import Oddities
    from fieldrig.traces.trace import TraceEntry

TraceFile = Annotated[Path, argument("FILE", "The trace file.")]
Buses = Annotated[
    list[str] | None,
    argument("[BUS]...", "Only these buses; a * matches any characters.", completion.bus),
]
From = Annotated[
    str | None,
    typer.Option(
        "--from", metavar="DURATION", help="Begin this time after the first message, such as 12.3s.", show_default=False
    ),
]
During = Annotated[
    str | None,
    typer.Option("--for", metavar="DURATION", help="Only messages of this time, such as 1s.", show_default=False),
]
MOST_NAMES: Final = 10_000
"""Names of buses or wires that are remembered for a message about one that is not there."""


def part_ns(begin: str | None, duration: str | None) -> tuple[int | None, int | None]:
    """Return the part of a file that --from and --for ask for, as `trace_files.read` takes it."""
    return None if begin is None else duration_ns(begin), None if duration is None else duration_ns(duration)


def report_oddities(file: Path, odd: "Oddities") -> None:
    """Say on the error output what was odd in a file, each kind once."""
    for oddity in odd:
        typer.echo(f"{file}: {oddity}", err=True)


class Messages:
    """The messages of a file that a command asks for, each time that it is iterated.

    After an iteration, UsageError for a bus or wire that the file does not have.
    """

    def __init__(
        self,
        file: Path,
        buses: list[str] | None = None,
        wires: list[str] | None = None,
        begin: str | None = None,
        duration: str | None = None,
    ) -> None:
        from fieldrig.traces.oddities import Oddities

        self._file, self._buses, self._wires = file, buses, wires
        self._part_ns = part_ns(begin, duration)
        self.odd = Oddities()
        self.buses: dict[str, str] = {}
        """The family of each chosen bus."""
        self.count = 0
        """Number of chosen messages."""

    def __iter__(self) -> Iterator["TraceEntry"]:
        from fieldrig.traces.trace_files import read

        found, named = dict[str, bool](), dict[str, bool]()
        for entry in read(self._file, *self._part_ns, self.odd):
            is_chosen = found.get(entry.bus)
            if is_chosen is None:
                is_chosen = _fits(entry.bus, self._buses)
                if len(found) < MOST_NAMES:
                    found[entry.bus] = is_chosen
            if is_chosen and (not self._wires or self._is_on_wire(entry, named)):
                self.count += 1
                self.buses[entry.bus] = entry.family
                yield entry
        self._check_there(self._buses, list(found), "bus")
        self._check_there(self._wires, list(named), "wire")

    def report_oddities(self) -> None:
        """Say on the error output what was odd in the file, each kind once."""
        report_oddities(self._file, self.odd)
        if self.count == 0 and self._part_ns != (None, None):
            typer.echo(f"{self._file}: no message is in this part of the time", err=True)

    def _is_on_wire(self, entry: "TraceEntry", named: dict[str, bool]) -> bool:
        wire = wire_of(entry)
        if wire is None:
            return False
        if wire not in named and len(named) < MOST_NAMES:
            named[wire] = _fits(wire, self._wires)
        return named[wire] if wire in named else _fits(wire, self._wires)

    def _check_there(self, patterns: list[str] | None, known: list[str], what: str) -> None:
        from fieldrig.errors import UsageError
        from fieldrig.text.nearest import closest

        pattern = unfit(patterns or (), known)
        if pattern is not None:
            raise UsageError(f"{self._file} has no messages of a {what} {pattern!r}", closest(pattern, known))


def _fits(name: str, patterns: list[str] | None) -> bool:
    return not patterns or any(fnmatchcase(name, pattern) for pattern in patterns)


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
