"""The commands `trace record`, `show` and `convert`."""

import time
from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import (
    AsJson,
    Count,
    Endpoint,
    For,
    argument,
    command_group,
    duration_ns,
    echo_json,
)
from fieldrig.cli.message_words import OfRig, bus_of, shower_of
from fieldrig.cli.names import Parts, unfit
from fieldrig.clock import S
from fieldrig.outside.addresses import DEFAULT_ENDPOINT
from fieldrig.text.digits import with_fewer_digits

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


TraceFile = Annotated[Path, argument("FILE", "The trace file.")]
Buses = Annotated[
    list[str] | None,
    argument("[BUS]...", "Only these buses; a * matches any characters.", completion.bus),
]


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


@app.command()
def show(
    file: TraceFile,
    buses: Buses = None,
    rig: OfRig = None,
    as_json: AsJson = False,
) -> None:
    """Print a trace, one line for each message.

    \b
        fieldrig trace show lab.jsonl
        fieldrig trace show lab.pcapng can0
        fieldrig trace show lab.jsonl --rig lab.yaml
        candump -L can0 > x.log; fieldrig trace show x.log
    """
    shower = shower_of(rig)
    for entry in _in_order(file, _survey(file, buses), buses):
        if as_json:
            echo_json(
                {
                    "time_ns": entry.time_ns,
                    "bus": entry.bus,
                    "family": entry.family,
                    "sender": entry.sender,
                    "data": entry.data.hex(),
                    "message": shower(entry),
                }
            )
        else:
            message = with_fewer_digits(shower(entry))
            typer.echo(f"{_instant(entry.time_ns)}  {entry.bus:8}  {entry.sender or '-':12}  {message}")


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
    _survey(file, buses, wires)
    chosen = _chosen(read(file), buses)
    taken = _Counted(chosen if not wires else _on_wires(chosen, wires))
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
        wire = _wire_of(entry)
        if wire is not None and any(fnmatchcase(wire, name) for name in names):
            yield entry


def _wire_of(entry: "TraceEntry") -> str | None:
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


def _survey(file: Path, buses: list[str] | None, wires: list[str] | None = None) -> bool:
    """Read a file once, and return whether its messages are in the order of time.

    UsageError for a bus or wire that the file does not have.
    """
    from fieldrig.traces.trace_files import read

    last_ns, is_in_order, found_buses, named = 0, True, dict[str, None](), dict[str, None]()
    for entry in read(file):
        found_buses[entry.bus] = None
        is_in_order &= entry.time_ns >= last_ns
        last_ns = entry.time_ns
        if wires and (wire := _wire_of(entry)) is not None:
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


def _in_order(file: Path, is_in_order: bool, buses: list[str] | None) -> "Iterable[TraceEntry]":
    """Return the messages in the order of time.  A file of several processes need not have it; then it is sorted."""
    from fieldrig.traces.trace_files import read

    chosen = _chosen(read(file), buses)
    return chosen if is_in_order else sorted(chosen, key=lambda entry: entry.time_ns)


def _chosen(entries: Iterable["TraceEntry"], buses: list[str] | None) -> Iterator["TraceEntry"]:
    for entry in entries:
        if not buses or any(fnmatchcase(entry.bus, pattern) for pattern in buses):
            yield entry


def _instant(time_ns: int) -> str:
    """Return the time of day, or seconds for virtual time, which starts at 0."""
    from fieldrig.traces.trace import is_time_of_day

    seconds, fraction_ns = divmod(time_ns, S)
    if not is_time_of_day(time_ns):
        return f"{seconds:8}.{fraction_ns // 1000:06}"
    return f"{time.strftime('%H:%M:%S', time.localtime(seconds))}.{fraction_ns // 1000:06}"
