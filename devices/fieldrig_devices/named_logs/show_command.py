"""The command `trace show`."""

from typing import Annotated

import typer

from fieldrig.cli.common import AsJson, echo_json
from fieldrig.cli.message_words import OfRig
from fieldrig.cli.trace_reading import Buses, During, From, Messages, TraceFile
from fieldrig.text.digits import with_fewer_digits
from fieldrig.text.one_line import one_line
from fieldrig_devices.named_logs.options import (
    Eds,
    Identifiers,
    Nodes,
    Registers,
    RegisterWords,
    Services,
    Units,
    chosen_by,
    named_log,
    report_skipped,
)

EveryFrame = Annotated[
    bool, typer.Option("--frames", "--all", help="A line for each message, also for those of one dialogue.")
]


def show(
    file: TraceFile,
    buses: Buses = None,
    rig: OfRig = None,
    eds: Eds = None,
    registers: Registers = None,
    nodes: Nodes = None,
    identifiers: Identifiers = None,
    units: Units = None,
    register_words: RegisterWords = None,
    services: Services = None,
    every_frame: EveryFrame = False,
    begin: From = None,
    duration: During = None,
    as_json: AsJson = False,
) -> None:
    """Print a log by name, with one line for each SDO transfer and each Modbus request with its answer.

    \b
        fieldrig trace show lab.jsonl
        fieldrig trace show machine.blf --eds 5=io32.eds --eds 6=drive.dcf
        fieldrig trace show meters.pcapng --registers 1=meter.yaml --register voltage
        fieldrig trace show lab.jsonl can0 --rig lab.yaml --service emcy
        fieldrig trace show night.blf --from 12.3s --for 1s --node 5
        candump -L can0 > x.log; fieldrig trace show x.log
    """
    from fieldrig.traces.instants import instant_in_column
    from fieldrig.traces.order import in_order
    from fieldrig_devices.dialogues.rtu_lines import RtuLines
    from fieldrig_devices.named_logs.rows import Rows

    names = named_log(rig, eds, registers)
    chosen = chosen_by(names, nodes, identifiers, units, register_words, services)
    messages = Messages(file, buses, begin=begin, duration=duration)
    lines = RtuLines(lambda bus: names.is_in_rig(bus, "serial"))
    rows = Rows(names, every_frame=every_frame, has_values=as_json).of(in_order(lines.of(messages)))
    for row in chosen.chosen(rows):
        if as_json:
            echo_json(row.as_data())
        else:
            words = with_fewer_digits(row.words)
            line = f"{instant_in_column(row.time_ns)}  {row.bus:8}  {row.sender or '-':12}  {words}"
            typer.echo(one_line(line))
    report_skipped(lines, messages.odd)
    messages.report_oddities()
