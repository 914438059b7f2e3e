"""The commands `trace record` and `convert`, and the group of all commands of traces."""

import time
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import (
    Count,
    Endpoint,
    For,
    argument,
    command_group,
    duration_ns,
)
from fieldrig.cli.installed import TraceCommands
from fieldrig.cli.names import Parts
from fieldrig.cli.trace_reading import Buses, During, From, Messages, TraceFile
from fieldrig.clock import S
from fieldrig.outside.addresses import DEFAULT_ENDPOINT

app = command_group(TraceCommands)


@app.callback()
def trace() -> None:
    """Record, show or convert traces.

    The ending of its name selects the format: .jsonl (every message), .log (candump), .asc, .blf (CANoe), .trc
    (PCAN-View), .csv, .db (python-can), .mf4, .pcap, .pcapng (Wireshark), .vcd (waveforms of wires). A file is read
    by its content.

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
    from fieldrig.traces.recorder import Recorder

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
    begin: From = None,
    duration: During = None,
) -> None:
    """Convert a trace to another format.

    \b
        fieldrig trace convert lab.jsonl lab.pcapng
        fieldrig trace convert lab.jsonl can0.log can0
        fieldrig trace convert lab.jsonl wires.vcd wires
        fieldrig trace convert lab.jsonl level.vcd --wire "tank.*"
        fieldrig trace convert night.blf minute.log --from 2min --for 1min
    """
    from fieldrig.points.values import counted
    from fieldrig.traces.formats import format_of
    from fieldrig.traces.trace_files import write

    families = format_of(target).FAMILIES
    messages = Messages(file, buses, wires, begin, duration)
    written = write(messages, target, messages.odd)
    left_out = ""
    if written < messages.count:
        left_out = f"; {messages.count - written} are of kinds that this format cannot hold"
        strange = sorted(bus for bus, family in messages.buses.items() if families and family not in families)
        left_out += f"; it has no messages of {', '.join(strange)}" if strange else ""
    messages.report_oddities()
    typer.echo(f"{target}: {counted(written, 'message')}{left_out}", err=True)
