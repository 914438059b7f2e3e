"""The commands `trace record` and `convert`, and the group of all commands of traces."""

import time
from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import (
    Count,
    Endpoint,
    For,
    argument,
    command_group,
    duration_ns,
)
from fieldrig.cli.names import Parts
from fieldrig.cli.trace_reading import Buses, TraceFile, chosen, survey, wire_of
from fieldrig.cli.trace_show import show
from fieldrig.clock import S
from fieldrig.outside.addresses import DEFAULT_ENDPOINT

if TYPE_CHECKING:
    from fieldrig.traces.trace import TraceEntry

app = command_group()


@app.callback()
def trace() -> None:
    """Record, show or convert traces.

    The ending of its name selects the format: .jsonl (every message), .log (candump), .pcapng (Wireshark),
    .vcd (waveforms of wires).

    \b
        fieldrig trace record lab.pcapng can0 --for 10s
        fieldrig trace show lab.pcapng can0
        fieldrig trace convert lab.pcapng lab.log
    """


@app.command()
def record(
    file: TraceFile,
    buses: Buses = None,
    count: Count = None,
    duration: For = None,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Record the messages of a running rig until Ctrl-C.

    \b
        fieldrig trace record lab.pcapng
        fieldrig trace record night.jsonl can0 wires --for 60min
        fieldrig trace record one.log can0 -n 100
    """
    from fieldrig.control.messages import Client
    from fieldrig.errors import UsageError
    from fieldrig.traces.trace_files import Recorder

    patterns = buses or ["*"]
    with Client(endpoint) as client:
        Parts(client).check_buses(patterns)
        give_up_s = None if duration is None else time.monotonic() + duration_ns(duration) / S
        recorder = Recorder(file, count)
        try:
            for published in client.inbox(["trace/*"]):
                if published is not None and any(fnmatchcase(published[0], pattern) for pattern in patterns):
                    recorder.take(*published)
                if recorder.is_full:
                    break
                if give_up_s is not None and time.monotonic() > give_up_s:
                    break
        except KeyboardInterrupt:
            typer.echo()
        finally:
            said = recorder.close()
    if not recorder.is_whole:
        raise UsageError(said, "" if recorder.taken else "no message came meanwhile; `fieldrig watch` shows them")
    typer.echo(said, err=True)


app.command()(show)


@app.command()
def convert(
    file: TraceFile,
    target: Annotated[Path, argument("TARGET", "The file to write.")],
    buses: Buses = None,
    wires: Annotated[
        list[str] | None,
        typer.Option(
            "--wire",
            metavar="NAME",
            help="Only wires of this name; a * matches any characters. May be given several times.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Convert a trace to another format.

    \b
        fieldrig trace convert lab.jsonl lab.pcapng
        fieldrig trace convert lab.jsonl can0.log can0
        fieldrig trace convert lab.jsonl wires.vcd wires
        fieldrig trace convert lab.jsonl level.vcd --wire "tank.*"
    """
    from fieldrig.points.values import counted
    from fieldrig.traces.trace_files import format_of, read, write

    format_of(target)
    survey(file, buses, wires)
    entries = chosen(read(file), buses)
    taken = _Counted(entries if not wires else _on_wires(entries, wires))
    written = write(taken, target)
    left_out = ""
    if written < taken.count:
        left_out = f"; {taken.count - written} are of kinds that this format cannot hold"
        families = format_of(target).FAMILIES
        strange = sorted(bus for bus, family in taken.buses.items() if families and family not in families)
        left_out += f"; it has no messages of {', '.join(strange)}" if strange else ""
    typer.echo(f"{target}: {counted(written, 'message')}{left_out}", err=True)


class _Counted:
    def __init__(self, entries: Iterable["TraceEntry"]) -> None:
        self._entries, self.count = entries, 0
        self.buses: dict[str, str] = {}
        """The family of each bus."""

    def __iter__(self) -> Iterator["TraceEntry"]:
        for entry in self._entries:
            self.count += 1
            self.buses[entry.bus] = entry.family
            yield entry


def _on_wires(entries: Iterable["TraceEntry"], names: list[str]) -> Iterator["TraceEntry"]:
    """Yield the messages that are values of wires of these names."""
    for entry in entries:
        wire = wire_of(entry)
        if wire is not None and any(fnmatchcase(wire, name) for name in names):
            yield entry
