"""The command `trace show`."""

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Final

import typer

from fieldrig.cli.common import AsJson
from fieldrig.cli.message_words import OfRig
from fieldrig.cli.trace_reading import Buses, During, From, Messages, TraceFile
from fieldrig.text.digits import with_fewer_digits
from fieldrig.text.one_line import one_line
from fieldrig.traces.instants import instant_in_column
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

if TYPE_CHECKING:
    from fieldrig_devices.named_logs.row import Row

AT_ONCE: Final = 256
"""Lines that are printed at once."""
EveryFrame = Annotated[
    bool, typer.Option("--frames", "--all", help="A line for each message, also for those of one dialogue.")
]
Learn = Annotated[
    bool,
    typer.Option(
        "--learn", help="With --from: also take the mappings that were configured before, which takes longer."
    ),
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
    has_learned: Learn = False,
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
    from fieldrig.traces.order import in_order
    from fieldrig_devices.dialogues.rtu_lines import RtuLines
    from fieldrig_devices.named_logs.rows import Rows

    names = named_log(rig, eds, registers)
    chosen = chosen_by(names, nodes, identifiers, units, register_words, services)
    messages = Messages(file, buses, begin=begin, duration=duration)
    lines = RtuLines(lambda bus: names.is_in_rig(bus, "serial"))
    rows = Rows(names, every_frame=every_frame, has_values=as_json)
    if has_learned and begin is not None:
        rows.learn(Messages(file, duration=begin))
    _print(map(_json if as_json else _line, chosen.chosen(rows.of(in_order(lines.of(messages))))))
    report_skipped(lines, messages.odd)
    messages.report_oddities()


def _print(texts: Iterable[str]) -> None:
    """Print lines, many at once, as each call of `echo` costs as much as a line; also those before an error."""
    waiting: list[str] = []
    try:
        for text in texts:
            waiting.append(text)
            if len(waiting) >= AT_ONCE:
                typer.echo("\n".join(waiting))
                waiting.clear()
    finally:
        if waiting:
            typer.echo("\n".join(waiting))


def _json(row: "Row") -> str:
    return json.dumps(row.as_data(), ensure_ascii=False)


def _line(row: "Row") -> str:
    words = with_fewer_digits(row.words)
    return one_line(f"{instant_in_column(row.time_ns)}  {row.bus:8}  {row.sender or '-':12}  {words}")
