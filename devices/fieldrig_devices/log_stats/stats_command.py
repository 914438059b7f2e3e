"""The command `trace stats`."""

from typing import Annotated

import typer

from fieldrig.cli.common import AsJson, echo_json
from fieldrig.cli.message_words import OfRig
from fieldrig.cli.trace_reading import Buses, During, From, Messages, TraceFile
from fieldrig_devices.named_logs.options import Eds, Registers, named_log, report_skipped

Bitrate = Annotated[
    int | None,
    typer.Option(
        "--bitrate",
        metavar="BIT/S",
        min=1_000,
        max=1_000_000,
        help="Bit rate of CAN, for the load.  [default: that of the rig, or 250000]",
        show_default=False,
    ),
]
DataBitrate = Annotated[
    int | None,
    typer.Option(
        "--data-bitrate",
        metavar="BIT/S",
        min=1_000,
        max=20_000_000,
        help="Bit rate of the data of CAN FD.  [default: 2000000]",
        show_default=False,
    ),
]


def stats(
    file: TraceFile,
    buses: Buses = None,
    rig: OfRig = None,
    eds: Eds = None,
    registers: Registers = None,
    bitrate: Bitrate = None,
    data_bitrate: DataBitrate = None,
    begin: From = None,
    duration: During = None,
    as_json: AsJson = False,
) -> None:
    """Count the messages of a log: by identifier, node and unit, with periods, load, answer times and errors.

    \b
        fieldrig trace stats machine.blf --bitrate 500000
        fieldrig trace stats lab.jsonl can0 --eds 5=io32.eds
        fieldrig trace stats meters.pcapng --json
    The period is the median of the times between messages, and the jitter is how far 98 of 100 are from it at most.
    Medians and other quantiles are exact up to 1000 values, and within 1 % above.
    """
    from fieldrig_devices.dialogues.rtu_lines import RtuLines
    from fieldrig_devices.log_stats.log_stats import LogStats
    from fieldrig_devices.log_stats.report import as_data, show

    names = named_log(rig, eds, registers)
    counted = LogStats(names, bitrate or names.bitrate(), data_bitrate)
    messages = Messages(file, buses, begin=begin, duration=duration)
    lines = RtuLines(lambda bus: names.is_in_rig(bus, "serial"))
    counted.read(lines.of(messages))
    if as_json:
        echo_json(as_data(counted))
    else:
        show(counted)
    report_skipped(lines, messages.odd)
    messages.report_oddities()
