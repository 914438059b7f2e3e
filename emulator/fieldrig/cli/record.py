"""The command `record`: signals of a running rig into a file, sampled where they are made."""

import asyncio
import time
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import Endpoint, argument, duration_ns, writing
from fieldrig.cli.names import Parts, check_name, check_patterns
from fieldrig.control import events
from fieldrig.outside.addresses import DEFAULT_ENDPOINT
from fieldrig.points.values import counted

if TYPE_CHECKING:
    from fieldrig.control.messages import Client, Control
    from fieldrig.recording.files import RowsFile
    from fieldrig.recording.reader import Rows
    from fieldrig.recording.signals import Rhythm

LATE_NS: Final = 50_000_000
"""How long rows of a rig in real time wait for others that may be earlier."""
LOOK_S: Final = 0.2
GONE_S: Final = 3.0
"""How long the rig's control endpoint may be silent before it counts as ended."""
SAY_S: Final = 1.0
"""Shortest time between two lines about what is lost."""


def record(
    signals: Annotated[
        list[str],
        argument(
            "SIGNAL...", "Points (DEVICE/KEY) and wires (BUS/WIRE); a * matches any characters.", completion.signal
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="The file to write: .csv, .vcd or .mf4.")],
    every: Annotated[
        str | None,
        typer.Option(metavar="DURATION", help="Sample once in this time, such as 10ms.", show_default=False),
    ] = None,
    changes: Annotated[bool, typer.Option("--changes", help="Record each change, with its instant.")] = False,
    duration: Annotated[
        str | None,
        typer.Option(
            "--for", metavar="DURATION", help="Stop after this time of the rig, such as 10s.", show_default=False
        ),
    ] = None,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Record signals of a running rig until Ctrl-C.

    \b
        fieldrig record tank/level wires/tank.* -o tank.csv
        fieldrig record belt/position belt/torque --for 10s -o belt.csv
        fieldrig record wires/*.on --changes -o switches.vcd
        fieldrig record tank/* --every 100ms -o tank.vcd

    Each device takes the samples itself, at the end of each of its cycles (once in a millisecond if it has none). At
    full speed in virtual time nothing is lost; in real time it is said what is.
    """
    from fieldrig.control.messages import Client
    from fieldrig.recording.file_formats import format_of

    if every is not None and changes:
        raise typer.BadParameter("--every and --changes exclude each other")
    rhythm: Rhythm = "change" if changes else "cycle" if every is None else duration_ns(every)
    length_ns = None if duration is None else duration_ns(duration)
    form = format_of(out)
    with Client(endpoint) as client:
        parts = Parts(client)
        names = _chosen(client, parts, signals)
    with writing(out), out.open("wb") as file:

        def open_file(columns: Any, begin_ns: int) -> "RowsFile":
            return form(file, columns, begin_ns)

        recorder = _Recorder(names, rhythm, open_file, 0 if parts.status["time"] == "virtual" else LATE_NS, out)
        said = asyncio.run(recorder.run(endpoint, parts.rig, length_ns))
    typer.echo(said, err=True)


def _chosen(client: "Client", parts: Parts, patterns: Sequence[str]) -> list[str]:
    """Return the signals of these patterns; a name without a * stays as it is, and the rig checks it."""
    names: dict[str, None] = {}
    for pattern in patterns:
        part, slash, key = pattern.partition("/")
        if not slash or not key:
            raise typer.BadParameter(
                f"{pattern!r} is not a signal; expected DEVICE/KEY or BUS/WIRE, such as tank/level"
            )
        known = [*parts.devices, *parts.buses]
        if "*" not in pattern:
            check_name(part, known, f"{parts.rig} has no device or bus")
            names[pattern] = None
            continue
        check_patterns([part], known, f"{parts.rig} has no device or bus")
        of_parts = [name for name in known if fnmatchcase(name, part)]
        found = [f"{name}/{signal}" for name in of_parts for signal in _keys(client, parts, name)]
        check_patterns([pattern], found, "there is no signal")
        names |= dict.fromkeys(name for name in found if fnmatchcase(name, pattern))
    return list(names)


def _keys(client: "Client", parts: Parts, name: str) -> list[str]:
    from fieldrig.errors import ControlError

    if name in parts.devices:
        return list(parts.ask_device(name, "keys"))
    try:
        return list(client.ask(f"bus/{name}/keys"))
    except ControlError:  # a bus without signals, or of a medium outside the rig
        return []


class _Recorder:
    """One recording into one file."""

    def __init__(self, names: list[str], rhythm: "Rhythm", open_file: Any, late_ns: int, out: Path) -> None:
        self._names, self._rhythm, self._open_file = names, rhythm, open_file
        self._late_ns, self._out = late_ns, out
        self._early: list[Rows] = []
        self._file: RowsFile | None = None
        self._end_ns = 1 << 62
        self._ended = asyncio.Event()
        self._lost = self._said_lost = 0
        self._said_s = 0.0
        self._failure: OSError | None = None
        """Why the file cannot be written any more."""

    async def run(self, endpoint: str, rig: str, length_ns: int | None) -> str:
        """Record to the end, and return what is to be said of it."""
        from fieldrig.control.endpoint import connect
        from fieldrig.control.messages import Control
        from fieldrig.recording.reader import Reader
        from fieldrig.system.this_process import on_signals

        control = Control(connect(endpoint), rig)
        try:
            reader = Reader(control, self._names, self._rhythm, self._on_rows, self._on_complete)
            columns = await reader.begin()
            file = self._file = self._open_file(columns, reader.begin_ns)
            self._end_ns = self._end_ns if length_ns is None else reader.begin_ns + length_ns
            on_signals(("SIGINT", "SIGTERM"), self._ended.set)
            control.listen_to("event", self._on_event)
            typer.echo(f"recording {counted(len(columns), 'signal')} in {self._out}; Ctrl-C ends it", err=True)
            await self._until_end(control, endpoint)
            await reader.end()
            if self._failure is not None:
                raise self._failure
            self._take_early()
            file.close(self._end_ns)
        finally:
            await control.close()
        lost = f"{counted(self._lost, 'sample')} lost" if self._lost else "nothing lost"
        return f"{self._out}: {counted(file.lines, 'instant')} of {counted(len(columns), 'signal')}, {lost}"

    async def _until_end(self, control: "Control", endpoint: str) -> None:
        from fieldrig.control.endpoint import is_answered

        answered_s = time.monotonic()
        while not self._ended.is_set():
            self._say_lost()
            if await asyncio.to_thread(is_answered, endpoint):
                answered_s = time.monotonic()
            elif time.monotonic() - answered_s > GONE_S:
                typer.echo("-- the rig has ended", err=True)
                return
            try:
                async with asyncio.timeout(LOOK_S):
                    await self._ended.wait()
            except TimeoutError:
                continue

    def _on_rows(self, rows: "Rows") -> None:
        self._lost += rows.lost
        self._early.append(rows)
        self._take_early()

    def _take_early(self) -> None:
        """Put the rows into the file, once it is open: the first come before `begin` has returned."""
        if self._file is not None:
            for rows in self._early:
                self._file.take(rows)
            self._early.clear()

    def _on_complete(self, until_ns: int) -> None:
        if self._failure is not None:
            return
        if self._file is not None:
            self._take_early()
            try:
                self._file.advance(min(until_ns - self._late_ns, self._end_ns))
            except OSError as cause:
                self._failure = cause
                self._ended.set()
        if until_ns - self._late_ns >= self._end_ns:
            self._ended.set()

    def _on_event(self, _: str, message: Any) -> None:
        event = events.taken(message)
        if event is not None and event.what in ("stopping", "stopped") and not event.process:
            typer.echo("-- the rig is being stopped", err=True)
            self._ended.set()

    def _say_lost(self) -> None:
        if self._lost != self._said_lost and time.monotonic() - self._said_s >= SAY_S:
            typer.echo(f"-- {counted(self._lost - self._said_lost, 'sample')} lost", err=True)
            self._said_lost, self._said_s = self._lost, time.monotonic()
